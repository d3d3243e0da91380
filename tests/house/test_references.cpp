// References in comments and documents resolve: to papers, to sections of docs/physics.md and to documents.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi::house;

// A document with each paragraph in one line, so that a reference may break over two.
std::string paragraphs_of(const std::string& text) {
  std::string paragraphs;
  for (const auto& line : lines_of(text)) {
    const auto begin = line.find_first_not_of(' ');
    const bool starts = begin == std::string::npos || line[begin] == '|' || line[begin] == '#';
    paragraphs += (starts ? "\n" : " ") + line.substr(std::min(begin, line.size()));
  }
  return paragraphs;
}

// The text of a file for people: all of a document, the comments of code, as lines that end where a comment ends.
std::string words_in(const std::string& name, const std::string& text) {
  if (name.ends_with(".md")) return paragraphs_of(text);
  const bool hash = name.ends_with(".py") || name.ends_with(".toml") || name.ends_with(".txt");
  static const std::regex kSlashes(R"(^(.*?)//+ ?(.*)$)"), kHash(R"(^(.*?)#+ ?(.*)$)");
  std::string words;
  for (const auto& line : lines_of(text)) {
    std::smatch comment;
    if (line.find(hash ? "#" : "//") == std::string::npos) continue;
    if (!std::regex_match(line, comment, hash ? kHash : kSlashes)) continue;
    const bool goes_on = comment[1].str().find_first_not_of(' ') == std::string::npos;
    words += (goes_on ? " " : "\n") + comment[2].str();
  }
  return words;
}

struct Sources {
  std::set<std::string> papers;  // "M", "Preetham 1999": the first column of the bibliography
  std::set<int> physics;         // its sections
  std::map<std::string, std::string> documents;
};

Sources sources_in(const Texts& documents) {
  Sources sources;
  sources.documents = documents;
  bool bibliography = false;
  static const std::regex kRow(R"(^\| ([^|]*[^| ]) +\|.*)"), kNumber(R"(^## ([0-9]+)\. .*)");
  for (const auto& line : lines_of(documents.at("docs/physics.md"))) {
    std::smatch part;
    if (line.starts_with("#")) bibliography = line == "## Sources";
    if (std::regex_match(line, part, kNumber)) sources.physics.insert(std::stoi(part[1]));
    if (!bibliography || !std::regex_match(line, part, kRow)) continue;
    std::istringstream keys(part[1]);  // "Bird 1986, SPCTRAL2": two names of one
    for (std::string key; std::getline(keys >> std::ws, key, ',');) sources.papers.insert(key);
  }
  return sources;
}

// "X Eq 3", "Adams and Baker 1999" of papers that the bibliography does not have.
void check_papers(const std::string& words, const Sources& sources, std::vector<std::string>& found) {
  static const std::regex kPlace(
      R"(\b([A-Z][A-Z0-9]*|report)(?:'s)?,? (?:Eqs?|Figs?|Tables?|Sects?|Chapter|Appendix) [A-Z]?[0-9])");
  static const std::regex kYear(
      R"(\b([A-Z][A-Za-z]*[a-z](?:-[A-Z][a-z]+)?)(?:(?:, [A-Z][a-z]+)* and [A-Z][a-z]+| et al\.)? ((?:19|20)[0-9][0-9])\b(?!-))");
  static const std::set<std::string> kMonths{"January", "February", "March",     "April",   "May",      "June",
                                             "July",    "August",   "September", "October", "November", "December"};
  for (std::sregex_iterator place(words.begin(), words.end(), kPlace), last; place != last; ++place)
    if (!sources.papers.contains((*place)[1])) found.push_back("no such paper: " + place->str());
  for (std::sregex_iterator year(words.begin(), words.end(), kYear), last; year != last; ++year) {
    const std::string author = (*year)[1], of = " " + (*year)[2].str();
    if (kMonths.contains(author) || sources.papers.contains(author + of)) continue;
    if (!sources.papers.contains(author.substr(0, author.find('-')) + of))
      found.push_back("no such paper: " + year->str());
  }
}

// "physics 12", "docs/air.md", `docs/sky.md ("Two suns")` that are not there.
void check_documents(const std::string& words, const Sources& sources, std::vector<std::string>& found) {
  static const std::regex kSection(R"(\bphysics(?:\.md)?[`\])]*,? (?:section )?([0-9]+)(?: and ([0-9]+))?\b)");
  static const std::regex kDocument(
      R"re(\b((?:docs|fixtures|tests)/[a-z/]*[A-Za-z-]+\.md)(?:,? \(?\\?"([^"\\]+)\\?")?)re");
  for (std::sregex_iterator section(words.begin(), words.end(), kSection), last; section != last; ++section)
    for (const int part : {1, 2})
      if ((*section)[part].matched && !sources.physics.contains(std::stoi((*section)[part])))
        found.push_back("no such section: " + section->str());
  for (std::sregex_iterator document(words.begin(), words.end(), kDocument), last; document != last; ++document) {
    const auto at = sources.documents.find((*document)[1]);
    if (at == sources.documents.end()) {
      found.push_back("no such document: " + document->str());
    } else if ((*document)[2].matched) {
      const auto headings = headings_of(at->second);
      if (std::none_of(headings.begin(), headings.end(),
                       [&](const std::string& heading) { return heading.starts_with((*document)[2].str()); }))
        found.push_back("no such heading: " + document->str());
    }
  }
}

std::vector<std::string> unresolved(const std::string& name, const std::string& text, const Sources& sources) {
  std::vector<std::string> found;
  const auto words = words_in(name, text);
  check_papers(words, sources, found);
  check_documents(words, sources, found);
  for (auto& one : found) one.insert(0, name + ": ");
  return found;
}

TEST(References, AllLeadSomewhere) {
  const auto files = repository_files();
  const auto sources = sources_in(texts_ending_in(files, {".md"}));
  EXPECT_TRUE(sources.papers.contains("M")) << "the bibliography was not found";
  int read = 0;
  for (const auto& [name, text] :
       texts_ending_in(files, {".md", ".cpp", ".hpp", ".glsl", ".frag", ".vert", ".py", ".toml", "CMakeLists.txt"})) {
    if (name.starts_with("tests/house/")) continue;  // offenders on purpose
    EXPECT_THAT(unresolved(name, text, sources), testing::IsEmpty());
    ++read;
  }
  EXPECT_GT(read, 500);
}

TEST(References, AnOffenderWouldBeFound) {
  const auto sources = sources_in({{"docs/physics.md",
                                    "# Physics\n\n## Sources\n\n| | |\n|---|---|\n| M | Morales |\n| Preetham 1999 | "
                                    "Daylight |\n\n## 1. Sky\n| B | |\n"},
                                   {"docs/sky.md", "# Sky\n\n## Two turbidities\n"}});
  const auto in_code = [&](const std::string& text) { return unresolved("a.hpp", text, sources); };
  EXPECT_THAT(in_code("// M Eq 3, Preetham 1999, physics 1, docs/sky.md (\"Two turbidities\"); May 2013\n"),
              testing::IsEmpty());
  EXPECT_THAT(in_code("int a;  // X Eq 3\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// the report's Eq 3\n"), testing::SizeIs(1)) << "whose?";
  EXPECT_THAT(in_code("// B Fig 4\n"), testing::SizeIs(1)) << "a row of another table";
  EXPECT_THAT(in_code("// all as in X\n// Table 3.1\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// Perez et al. 1993\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// Preetham, Shirley and Smits 2001\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// physics 1 and 2\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// docs/air.md\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("// docs/sky.md, \"Three turbidities\"\n"), testing::SizeIs(1));
  EXPECT_THAT(in_code("call(\"X Eq 3\");\n"), testing::IsEmpty()) << "not a comment";
  EXPECT_THAT(unresolved("docs/a.md", "As in X\nEq 3.\n", sources), testing::SizeIs(1));
}

}  // namespace
