// What is written beside a table of figures may not contradict it. A paragraph below a table with a `figures:` mark, up
// to the next table or heading, uses only figures of that table and of the next one in its section, which it may
// introduce. Any paragraph may name further tables, and is then checked wherever it stands:
//
//   <!-- quotes: #found-building, accuracy.md#found-measured -->   names as the tables' marks have them
//
// Figures that no table has say where they are from, as tables do: `<!-- by hand: WHY -->`, `<!-- from: WHOM -->`. Of
// README.md every paragraph is checked, since none of the tables stands there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <regex>
#include <utility>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using kasumi::house::lines_of;
using kasumi::house::Texts;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

// The text as it is read aloud: no comments, code, places of links; one blank between words.
std::string read_aloud(std::string text) {
  static const std::regex kComment("<!--[^>]*-->"), kCode("`[^`]*`"), kPlace(R"(\]\([^)]*\))"), kBlanks(R"(\s+)");
  text = std::regex_replace(text, kComment, " ");
  text = std::regex_replace(text, kCode, "_");
  text = std::regex_replace(text, kPlace, "]");
  return std::regex_replace(text, kBlanks, " ");
}

struct Number {
  std::size_t begin = 0, end = 0;
  std::string spelled;  // ".05" of "0.05", "1306" of "1,306"
};

// Numbers that stand for themselves, not those within a name (M14, 8-bit, Apache-2.0, 16:31, r^2).
std::vector<Number> numbers_of(const std::string& text) {
  static const std::regex kNumber(R"((\d{1,3}(,\d{3})+|\d*)(\.\d+)?(e-?\d+)?)");
  std::vector<Number> numbers;
  const auto at = [&](std::size_t i) { return i < text.size() ? text[i] : ' '; };
  for (std::size_t begin = 0; begin < text.size(); ++begin) {
    if (!is_digit(text[begin]) && !(text[begin] == '.' && is_digit(at(begin + 1)))) continue;
    std::smatch match;
    std::regex_search(text.cbegin() + static_cast<std::ptrdiff_t>(begin), text.cend(), match, kNumber,
                      std::regex_constants::match_continuous);
    const std::size_t end = begin + static_cast<std::size_t>(match.length());
    const char before = begin > 0 ? text[begin - 1] : ' ', further = begin > 1 ? text[begin - 2] : ' ';
    const bool after_name = is_letter(before) || before == '_' || before == '^' ||
                            ((before == '-' || before == ':') && (is_letter(further) || is_digit(further)) &&
                             !(before == '-' && is_digit(further)));
    const bool before_name = is_letter(at(end)) || at(end) == '_' || at(end) == '^' ||
                             (at(end) == '-' && is_letter(at(end + 1))) || (at(end) == ':' && is_digit(at(end + 1)));
    if (!after_name && !before_name) {
      std::string spelled = match.str();
      std::erase(spelled, ',');
      if (spelled.starts_with("0.")) spelled.erase(0, 1);
      numbers.push_back({begin, end, spelled});
    }
    begin = end - 1;
  }
  return numbers;
}

// "... of T 2 to " and "Debian ", "Table ", "AOD = ": the numbers after these are values of a setting, or names.
bool ends_in_a_name(const std::string& text) {
  static const std::regex kWord(R"(([A-Za-z]+)(?: =)? ?[-+]?$)");
  static const std::regex kSymbol("[A-Z]+"), kReference("(table|tables|fig|eq|sect|section|chapter)");
  std::smatch word;
  if (!std::regex_search(text, word, kWord)) return false;
  const std::string name = word[1];
  if (std::regex_match(name, kSymbol)) return true;
  if (std::regex_match(name, std::regex(kReference)) ||
      std::regex_match(static_cast<char>(std::tolower(name[0])) + name.substr(1), kReference))
    return true;
  if (!std::isupper(static_cast<unsigned char>(name[0]))) return false;
  const auto before = text.find_last_not_of(" *(\"-", static_cast<std::size_t>(word.position(1)) - 1);
  return word.position(1) > 0 && before != std::string::npos &&
         std::string(".:?!").find(text[before]) == std::string::npos;
}

// The figures of a text: its numbers but for those that say where, when or of what something was measured. Not figures
// are names, years, the 255 that errors are parts of, and lists of numbers ("0, 400 and 1000 m") that follow a symbol
// ("T 2 to 8", "N = 100") or are lengths, angles, pixels, bits or dates.
std::vector<std::string> figures_of(const std::string& markdown) {
  static const std::regex kBetween(R"((,| and|, and| to| or|;| x| \+-) [-+]?|-|\.\.)");
  static const std::regex kUnit(
      R"(^ ?(km|m|nm|um|cm|deg|degrees|px|pixels|bits|hours|minutes|min|January|February|March|April|May|June|July|August|September|October|November|December)\b)");
  static const std::regex kYear("(19|20)[0-9][0-9]");
  const std::string text = read_aloud(markdown);
  const auto numbers = numbers_of(text);
  std::vector<std::string> figures;
  for (std::size_t first = 0, last = 0; first < numbers.size(); first = last + 1) {
    bool product = false;
    for (last = first; last + 1 < numbers.size(); ++last) {
      const auto between = text.substr(numbers[last].end, numbers[last + 1].begin - numbers[last].end);
      if (!std::regex_match(between, kBetween)) break;
      product = product || between == " x ";
    }
    const std::size_t begin = numbers[first].begin, near_enough = 40;
    const std::string before = text.substr(begin - std::min(begin, near_enough), std::min(begin, near_enough));
    const std::string after = text.substr(numbers[last].end, near_enough);
    if (product || ends_in_a_name(before) || std::regex_search(after, kUnit)) continue;
    for (std::size_t i = first; i <= last; ++i) {
      const auto& spelled = numbers[i].spelled;
      const bool scale = spelled == "255" && i == first && (before.ends_with("of ") || before.ends_with("/ "));
      if (!scale && !std::regex_match(spelled, kYear)) figures.push_back(spelled);
    }
  }
  return figures;
}

struct Passage {
  enum class Kind { heading, comment, table, prose } kind;
  int line = 0;
  std::string text;
};

std::vector<Passage> passages_of(const std::string& page) {
  using Kind = Passage::Kind;
  std::vector<Passage> passages;
  bool fenced = false, continued = false;
  int number = 0;
  for (const auto& line : lines_of(page)) {
    ++number;
    const bool fence = line.starts_with("```");
    if (fence) fenced = !fenced;
    const bool in_comment =
        continued && passages.back().kind == Kind::comment && passages.back().text.find("-->") == std::string::npos;
    if (fenced || fence || (line.empty() && !in_comment)) {
      continued = false;
      continue;
    }
    if (!continued && line.starts_with("    ")) continue;  // code
    Kind kind = Kind::prose;
    if (in_comment || line.starts_with("<!--"))
      kind = Kind::comment;
    else if (line.starts_with("#"))
      kind = Kind::heading;
    else if (line.starts_with("|"))
      kind = Kind::table;
    const bool joins =
        continued && passages.back().kind == kind && kind != Kind::heading && (kind != Kind::comment || in_comment);
    if (joins)
      passages.back().text += (kind == Kind::comment ? " " : "\n") + line;
    else
      passages.push_back({kind, number, line});
    continued = true;
  }
  return passages;
}

// "found-building" of a table's mark; of a table without a name the commands that print it.
std::string name_in_mark(const std::string& mark) {
  static const std::regex kFigures(R"(<!-- figures: (?:([a-z0-9-]+) by )?(.+) -->)");
  std::smatch match;
  if (!std::regex_match(mark, match, kFigures)) return "";
  return match[1].matched ? match[1] : match[2];
}

// "docs/accuracy.md#found-building" of "accuracy.md#found-building" on docs/README.md.
std::string absolute_name(const std::string& page, const std::string& quoted) {
  if (quoted.starts_with("#")) return page + quoted;
  return (std::filesystem::path(page).parent_path() / quoted).lexically_normal().generic_string();
}

std::map<std::string, std::set<std::string>> figures_by_table(const Texts& pages) {
  std::map<std::string, std::set<std::string>> tables;
  for (const auto& [page, text] : pages) {
    std::string name;
    for (const auto& passage : passages_of(text)) {
      if (passage.kind == Passage::Kind::table && !name.empty())
        for (const auto& figure : figures_of(passage.text)) tables[page + "#" + name].insert(figure);
      name = passage.kind == Passage::Kind::comment ? name_in_mark(passage.text) : "";
    }
  }
  return tables;
}

// What contradicts the tables, or cannot be compared with them: "docs/a.md:3: no table has 4.0, 4.5".
std::vector<std::string> figures_without_a_table(const Texts& pages) {
  using Kind = Passage::Kind;
  static const std::regex kOrigin("<!-- (by hand: |from: |goals)[^]*"), kQuotes("<!-- quotes: ([^]+) -->");
  static const std::regex kName(R"([^,\s][^,]*)");
  const auto tables = figures_by_table(pages);
  std::vector<std::string> problems;
  for (const auto& [page, text] : pages) {
    const auto passages = passages_of(text);
    std::string mark;
    std::optional<std::string> above;  // the table with a mark, below which the passages stand
    for (std::size_t i = 0; i < passages.size(); ++i) {
      const auto& passage = passages[i];
      const std::string own_mark = std::exchange(mark, passage.kind == Kind::comment ? passage.text : "");
      if (passage.kind == Kind::heading) above.reset();
      if (passage.kind == Kind::table)
        above = name_in_mark(own_mark).empty() ? std::nullopt : std::optional(passage.text);
      std::smatch quotes;
      const bool quoting = std::regex_match(own_mark, quotes, kQuotes);
      if (passage.kind != Kind::prose || passage.text.starts_with("![") || std::regex_match(own_mark, kOrigin) ||
          (!above && !quoting && page != "README.md"))
        continue;
      std::set<std::string> known;
      if (above) {
        std::size_t next = i;
        while (next < passages.size() && passages[next].kind != Kind::table && passages[next].kind != Kind::heading)
          ++next;
        const bool introduces = next < passages.size() && passages[next].kind == Kind::table;
        for (const auto& figure : figures_of(*above + (introduces ? "\n" + passages[next].text : "")))
          known.insert(figure);
      }
      const std::string names = quoting ? quotes[1].str() : "";
      for (std::sregex_iterator name(names.begin(), names.end(), kName), last; name != last; ++name) {
        const auto table = tables.find(absolute_name(page, name->str()));
        if (table == tables.end())
          problems.push_back(fmt::format("{}:{}: no table {}", page, passage.line, name->str()));
        else
          known.insert(table->second.begin(), table->second.end());
      }
      std::string unknown;
      for (const auto& figure : figures_of(passage.text))
        if (!known.contains(figure)) unknown += (unknown.empty() ? "" : ", ") + figure;
      if (!unknown.empty()) problems.push_back(fmt::format("{}:{}: no table has {}", page, passage.line, unknown));
    }
  }
  return problems;
}

// The words of a passage of the document `page.md` below a table of the figures 3.6 and 12 of 14.
std::vector<std::string> problems_of(const std::string& words) {
  const std::string table =
      "## A\n\n<!-- figures: a by build/x -->\n\n| of | error |\n|---|---|\n| T 4, sun 31 deg high | 3.6 |\n| sun | 12 "
      "of 14 |\n\n";
  return figures_without_a_table({{"docs/page.md", table + words}});
}

TEST(FiguresInProse, AreThoseOfTheTableAbove) {
  EXPECT_THAT(problems_of("In thin haze 3.6 of 255, found in 12 of 14.\n"), IsEmpty());
  EXPECT_THAT(problems_of("In thin haze 4.0 and\n4.5 of 255.\n"),
              ElementsAre("docs/page.md:10: no table has 4.0, 4.5"));
  EXPECT_THAT(problems_of("Words.\n\n- In 13 of 14.\n"), ElementsAre("docs/page.md:12: no table has 13"));
  EXPECT_THAT(problems_of("Off by 4.\n"), SizeIs(1)) << "T 4 is a setting";
  EXPECT_THAT(problems_of("## B\n\nOff by 4.0.\n"), IsEmpty()) << "of another section";
  EXPECT_THAT(problems_of("| a |\n|---|\n| b |\n\nOff by 4.0.\n"), IsEmpty()) << "of a table without a mark";
  EXPECT_THAT(problems_of("Off by 7.7 then:\n\n| a | b |\n|---|---|\n| c | 7.7 |\n"), IsEmpty()) << "of the next table";
}

TEST(FiguresInProse, AreNotWhatSaysWhereWhenAndOfWhat) {
  for (const char* words :
       {"T 2.4, and T 2.5 and 4", "N = 100", "500 x 500 pixels", "sun 1 to 12 deg high, 0, 400 and 1000 m away",
        "M14 Table 2", "M Eq 3.2-3.4", "a fresh Debian 12", "Preetham 1999, 27 May 2013, at 16:31", "an 8-bit picture",
        "Apache-2.0, CIEDE2000", "`--frames 7`", "[physics.md, section 8](physics.md#8-composition)", "r^2",
        "errors are of 255, or / 255"})
    EXPECT_THAT(figures_of(words), IsEmpty()) << words;
  EXPECT_THAT(figures_of("Worst .14, 1.5 to 2 %, 0.05 and 1,306 of 3e-04 at T 8: -.3 of 255. Of 12"),
              ElementsAre(".14", "1.5", "2", ".05", "1306", "3e-04", ".3", "12"));
}

TEST(FiguresInProse, OfNoTableSayWhereTheyAreFrom) {
  EXPECT_THAT(problems_of("<!-- by hand: seen once -->\nOff by 4.0.\n"), IsEmpty());
  EXPECT_THAT(problems_of("<!-- from: M Table 1 -->\n\nOff by 4.0.\n"), IsEmpty());
  EXPECT_THAT(problems_of("<!-- by hand: seen once -->\nOff by 4.0.\n\nOff by 4.5.\n"), SizeIs(1));
  EXPECT_THAT(problems_of("<!-- goals -->\nBy .6.\n<!-- end of goals -->\n"), IsEmpty())
      << "docs/rewrite-figures wrote it";
}

TEST(FiguresInProse, MayQuoteTablesOfOtherPages) {
  const std::string table = "<!-- figures: a by build/x -->\n\n| of | error |\n|---|---|\n| T 4 | 11.7 |\n";
  const auto problems = [&](const std::string& page, const std::string& words) {
    return figures_without_a_table({{"docs/a.md", table}, {page, words}});
  };
  EXPECT_THAT(problems("README.md", "<!-- quotes: docs/a.md#a -->\nOff by 11.7 of 255.\n"), IsEmpty());
  EXPECT_THAT(problems("README.md", "<!-- quotes: docs/a.md#a -->\nOff by 17 of 255.\n"),
              ElementsAre("README.md:2: no table has 17"));
  EXPECT_THAT(problems("README.md", "Off by 11.7 of 255.\n"), SizeIs(1)) << "quotes no table";
  EXPECT_THAT(problems("docs/b.md", "Off by 17.\n"), IsEmpty()) << "far from any table";
  EXPECT_THAT(problems("docs/b.md", "<!-- quotes:\na.md#a -->\nOff by 17.\n"),
              ElementsAre("docs/b.md:3: no table has 17"));
  EXPECT_THAT(problems("docs/b.md", "<!-- quotes: a.md#b -->\nNothing.\n"),
              ElementsAre("docs/b.md:2: no table a.md#b"));
}

TEST(FiguresInProse, OfTheDocumentsAreThoseOfTheirTables) {
  const auto pages = kasumi::house::texts_ending_in(kasumi::house::repository_files(), {".md"});
  EXPECT_GT(figures_by_table(pages).size(), 10U);
  EXPECT_THAT(figures_without_a_table(pages), IsEmpty());
}

}  // namespace
