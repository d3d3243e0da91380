// The documents: their links resolve, every one is in the index, and none is wider than a screen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <functional>
#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi::house;

constexpr int kWidest = 120;  // characters

// The anchor that GitHub and GitLab give a heading: "Two turbidities" is #two-turbidities.
std::string anchor_of(const std::string& heading) {
  static const std::regex kLink(R"(\[([^\]]*)\]\([^)]*\))");
  std::string anchor;
  for (const char c : std::regex_replace(heading, kLink, "$1")) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ')
      anchor += '-';
    else if (std::isalnum(byte) || c == '-' || c == '_' || byte >= 0x80)
      anchor += static_cast<char>(std::tolower(byte));
  }
  return anchor;
}

// Calls use(target) for every link and picture of a document: "sky.md#drawing-it".
void for_each_link(const std::string& document, const std::function<void(const std::string&)>& use) {
  static const std::regex kCode("`[^`]*`"), kLink(R"(\]\(([^)\s]+)\))");
  std::string prose;
  for (const auto& line : lines_of_prose(document)) prose += line + '\n';
  prose = std::regex_replace(prose, kCode, "");
  for (std::sregex_iterator link(prose.begin(), prose.end(), kLink), last; link != last; ++link) use((*link)[1]);
}

// The file that a link from `document` leads to, from the root, and its anchor; empty for a link to elsewhere.
std::pair<std::string, std::string> target_of(const std::string& document, const std::string& link) {
  if (link.find("://") != std::string::npos) return {};
  const auto hash = link.find('#');
  const auto file = link.substr(0, hash);
  const auto folder = std::filesystem::path(document).parent_path();
  return {file.empty() ? document : (folder / file).lexically_normal().generic_string(),
          hash == std::string::npos ? "" : link.substr(hash + 1)};
}

std::vector<std::string> broken_links(const Texts& documents, const std::set<std::string>& files) {
  std::vector<std::string> found;
  for (const auto& [name, text] : documents) {
    for_each_link(text, [&, &name = name](const std::string& link) {
      const auto [file, anchor] = target_of(name, link);
      if (file.empty()) return;
      if (!files.contains(file)) return found.push_back(fmt::format("{}: no such file: {}", name, link));
      if (anchor.empty()) return;
      std::set<std::string> anchors;
      if (documents.contains(file))
        for (const auto& heading : headings_of(documents.at(file))) anchors.insert(anchor_of(heading));
      if (!anchors.contains(anchor)) found.push_back(fmt::format("{}: no such heading: {}", name, link));
    });
  }
  return found;
}

// The files in `folder` with this ending to which no document links.
std::vector<std::string> never_linked(const Texts& documents, const std::set<std::string>& files,
                                      const std::string& folder, const std::string& ending) {
  std::set<std::string> linked;
  for (const auto& [name, text] : documents)
    for_each_link(text, [&, &name = name](const std::string& link) { linked.insert(target_of(name, link).first); });
  std::vector<std::string> found;
  for (const auto& file : files)
    if (file.starts_with(folder) && file.ends_with(ending) && !linked.contains(file)) found.push_back(file);
  return found;
}

// Tables cannot be wrapped, nor can addresses and the markers of figures.
std::vector<std::string> wide_lines(const std::string& name, const std::string& text) {
  std::vector<std::string> found;
  int number = 0;
  for (const auto& line : lines_of(text)) {
    ++number;
    int characters = 0;
    for (const char c : line) characters += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    const bool bound = line.starts_with("|") || line.starts_with("<!--") || line.find("://") != std::string::npos;
    if (characters > kWidest && !bound) found.push_back(fmt::format("{}:{}: {} characters", name, number, characters));
  }
  return found;
}

TEST(Documents, LinkOnlyToWhatIsThere) {
  const auto files = repository_files();
  const auto documents = texts_ending_in(files, {".md"});
  EXPECT_GT(documents.size(), 15u) << "the documents were not found";
  EXPECT_THAT(broken_links(documents, files), testing::IsEmpty());
}

TEST(Documents, AreAllInTheIndex) {
  const auto files = repository_files();
  EXPECT_THAT(never_linked(texts_ending_in(files, {"docs/README.md"}), files, "docs/", ".md"),
              testing::ElementsAre("docs/README.md"));
}

TEST(Documents, ShowEveryPictureThatIsKeptForThem) {
  const auto files = repository_files();
  EXPECT_THAT(never_linked(texts_ending_in(files, {".md"}), files, "docs/pictures/", ".jpg"), testing::IsEmpty());
}

TEST(Documents, AreNoWiderThanAScreen) {
  for (const auto& [name, text] : texts_ending_in(repository_files(), {".md"}))
    EXPECT_THAT(wide_lines(name, text), testing::IsEmpty());
}

TEST(Documents, AnOffenderWouldBeFound) {
  const std::set<std::string> files{"README.md", "docs/a.md", "docs/b.md", "docs/pictures/c.jpg"};
  const auto broken = [&](const std::string& text) {
    return broken_links({{"docs/a.md", text}, {"docs/b.md", "# B\n\n## The `air`, again\n"}}, files);
  };
  EXPECT_THAT(broken("[b](b.md#the-air-again) [top](../README.md) ![c](pictures/c.jpg) <https://kasumi.example>\n"),
              testing::IsEmpty());
  EXPECT_THAT(broken("[b](docs/b.md)\n"), testing::SizeIs(1));
  EXPECT_THAT(broken("![d](pictures/d.jpg)\n"), testing::SizeIs(1));
  EXPECT_THAT(broken("[b](b.md#the-sky)\n"), testing::SizeIs(1));
  EXPECT_THAT(broken("[here](#the-air-again)\n"), testing::SizeIs(1));
  EXPECT_THAT(broken("`[b](c.md)`\n\n    [b](c.md)\n\n```\n[b](c.md)\n```\n"), testing::IsEmpty());

  EXPECT_THAT(never_linked({{"docs/README.md", "[a](a.md)"}}, files, "docs/", ".md"),
              testing::ElementsAre("docs/b.md"));
  EXPECT_THAT(wide_lines("a.md", std::string(kWidest, 'x') + "\n"), testing::IsEmpty());
  EXPECT_THAT(wide_lines("a.md", "short\n" + std::string(kWidest + 1, 'x') + "\n"),
              testing::ElementsAre("a.md:2: 121 characters"));
  EXPECT_THAT(wide_lines("a.md", "|" + std::string(kWidest, 'x') + "\n"), testing::IsEmpty());
}

}  // namespace
