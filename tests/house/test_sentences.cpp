// The ten pages that visitors, installers, operators and curators read first are easy to read: sentences of 20 words in
// the mean of a page, and none above 40. Code, tables, lists, headings and captions of pictures do not count.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi::house;

constexpr std::array<const char*, 10> kReadFirst{
    "README.md",          "docs/calibration.md", "docs/cameras.md",   "docs/content.md",     "docs/faults.md",
    "docs/installing.md", "docs/models.md",      "docs/operating.md", "docs/photographs.md", "docs/updates.md"};
constexpr int kMostWords = 40;
constexpr double kMostWordsInTheMean = 20.0;

struct Sentence {
  int line = 0;  // where its paragraph begins
  std::string text;
};

// A sentence ends at a full stop, question or exclamation mark before a capital, a digit or code; "1, 2 .. 15" goes on.
std::vector<std::string> split_into_sentences(const std::string& paragraph) {
  static const std::regex kCode("`[^`]*`"), kLink(R"(!?\[([^\]]*)\]\([^)]*\))"),
      kEnd(R"(([^\s.][.?!][*"')]*)\s+(?=[*"'(]*[A-Z0-9.@]))");
  auto text = std::regex_replace(paragraph, kCode, "@");
  text = std::regex_replace(text, kLink, "$1");
  text = std::regex_replace(text, kEnd, "$1\n");
  return lines_of(text);
}

std::vector<Sentence> sentences_of(const std::string& page) {
  std::vector<Sentence> sentences;
  std::string paragraph;
  bool fenced = false, in_comment = false, counts = false, inside = false;
  int number = 0, begin = 0;
  const auto end_paragraph = [&] {
    if (inside && counts)
      for (const auto& text : split_into_sentences(paragraph)) sentences.push_back({begin, text});
    paragraph.clear();
    inside = false;
  };
  static const std::regex kNoProse(R"(^(\||#|!\[| ).*|^(-|\*|[0-9]+\.) .*)");
  for (const auto& line : lines_of(page)) {
    ++number;
    const bool fence = line.starts_with("```"), comment = in_comment || line.starts_with("<!--");
    if (comment) in_comment = line.find("-->") == std::string::npos;
    if (fence) fenced = !fenced;
    const bool row_or_heading = line.starts_with("|") || line.starts_with("#");
    if (fence || fenced || comment || line.empty() || (inside && row_or_heading)) {
      end_paragraph();
      continue;
    }
    if (!inside) {
      begin = number;
      counts = !std::regex_match(line, kNoProse);
    }
    inside = true;
    paragraph += line + " ";
  }
  end_paragraph();
  return sentences;
}

int words_in(const std::string& sentence) {
  std::istringstream stream(sentence);
  int words = 0;
  for (std::string word; stream >> word;)
    words += std::ranges::any_of(word, [](unsigned char c) { return std::isalnum(c) || c == '@'; });
  return words;
}

std::vector<std::string> hard_to_read(const std::string& name, const std::string& page) {
  std::vector<std::string> found;
  int words = 0, count = 0;
  for (const auto& sentence : sentences_of(page)) {
    const int here = words_in(sentence.text);
    if (here > kMostWords)
      found.push_back(fmt::format("{}:{}: {} words: {}", name, sentence.line, here, sentence.text));
    words += here;
    ++count;
  }
  const double mean = count == 0 ? 0.0 : static_cast<double>(words) / count;
  if (mean > kMostWordsInTheMean)
    found.push_back(fmt::format("{}: {:.1f} words a sentence in the mean of {}", name, mean, count));
  return found;
}

TEST(Sentences, OfThePagesReadFirstAreShort) {
  for (const std::string name : kReadFirst) {
    const auto page = kasumi::read_text_file(kasumi::source_folder() / name).value();
    EXPECT_GE(sentences_of(page).size(), 10u) << name;
    EXPECT_THAT(hard_to_read(name, page), testing::IsEmpty());
  }
}

TEST(Sentences, OfAnOffenderAreFound) {
  std::string long_one = "It";
  for (int i = 0; i < 40; ++i) long_one += " goes";
  EXPECT_THAT(hard_to_read("a.md", "Short.\n\n" + long_one + " on.\n"),
              testing::Contains(testing::HasSubstr("a.md:3: 42 words: It goes")));
  std::string many = "It";
  for (int i = 0; i < 21; ++i) many += " goes";
  EXPECT_THAT(hard_to_read("a.md", many + ".\n"), testing::SizeIs(1)) << "22 in the mean";
  for (const std::string no_prose : {"    ", "| ", "- ", "1. ", "# ", "![", "```\n", "<!-- "})
    EXPECT_THAT(hard_to_read("a.md", no_prose + long_one + "\n"), testing::IsEmpty()) << no_prose;
}

TEST(Sentences, EndWhereANewOneBegins) {
  const auto ends = [](const std::string& text) { return split_into_sentences(text).size(); };
  EXPECT_EQ(ends("One. Two, T = 2.5 deg, i.e. three. `Code` ends it? (Yes.) *So* be .5 of it."), 5u);
  EXPECT_EQ(ends("See [b. C](d.md) at 1, 2 .. 15 s."), 2u) << "a link's words are read, too";
  EXPECT_EQ(words_in("The @ of *it* - 3 +- .5 m."), 7);
}

}  // namespace
