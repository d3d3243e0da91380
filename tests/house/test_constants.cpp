// In the folders that decide what visitors see and operators hear, every constant says why it has its value.
#include <algorithm>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/house/repository.hpp"

namespace kasumi::house {
namespace {

// Files or folders whose constants all have a reason.
const std::vector<std::string> kExplained{"estimator/",
                                          "gles/composite/",
                                          "gles/object/",
                                          "pipeline/install/camera_drift/",
                                          "pipeline/kiosk/appliance/",
                                          "pipeline/kiosk/start/",
                                          "pipeline/show/",
                                          "pipeline/site/config/ladder",
                                          "report/"};
// Not yet; a line that is no longer needed fails the test.
const std::vector<std::string> kNotYet{"pipeline/kiosk/appliance/render_loop.cpp",
                                       "pipeline/kiosk/appliance/sky_loop.cpp", "report/channels/", "report/page/",
                                       "report/diagnosis/"};

bool begins_with_any(const std::string& name, const std::vector<std::string>& beginnings) {
  return std::ranges::any_of(beginnings, [&](const auto& beginning) { return name.starts_with(beginning); });
}

bool is_comment(const std::string& line) {
  return line.find_first_not_of(' ') == line.find("//") && line.find("//") != std::string::npos;
}

// "12: kMost" of each constant without a comment on its lines, just above, or above the unbroken block of constants
// that it stands in.
std::vector<std::string> unexplained_in(const std::string& text) {
  static const std::regex constant(R"(^\s*(?:inline |static )*constexpr\b.*?\b(k[A-Z]\w*)(?:\[\w*\])*\s*[={])");
  const auto lines = lines_of(text);
  std::vector<std::string> found;
  bool headed = false;  // the block has a comment above
  for (std::size_t i = 0, end_of_last = 0; i < lines.size(); ++i) {
    std::smatch match;
    if (!std::regex_search(lines[i], match, constant)) continue;
    if (i > 0 && is_comment(lines[i - 1]))
      headed = true;
    else if (i == 0 || end_of_last != i)
      headed = false;
    bool explained = headed;
    std::size_t last = i;
    for (;; ++last) {
      const auto slashes = lines[last].find("//");
      explained = explained || slashes != std::string::npos;
      if (lines[last].substr(0, slashes).find(';') != std::string::npos || last + 1 == lines.size()) break;
    }
    if (!explained) found.push_back(fmt::format("{}: {}", i + 1, match[1].str()));
    i = last;
    end_of_last = last + 1;
  }
  return found;
}

TEST(Constants, SayWhyTheyHaveTheirValues) {
  std::vector<std::string> found;
  std::set<std::string> needed;
  std::size_t files = 0;
  for (const auto& [name, text] : texts_ending_in(repository_files(), {".hpp", ".cpp"})) {
    if (!begins_with_any(name, kExplained)) continue;
    ++files;
    const auto unexplained = unexplained_in(text);
    if (unexplained.empty()) continue;
    const auto excused = std::ranges::find_if(kNotYet, [&](const auto& one) { return name.starts_with(one); });
    if (excused != kNotYet.end())
      needed.insert(*excused);
    else
      for (const auto& one : unexplained) found.push_back(name + ":" + one);
  }
  EXPECT_GT(files, 300u) << "the files were not read";
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_THAT(kNotYet, testing::UnorderedElementsAreArray(needed));
}

TEST(Constants, OneWithoutAReasonWouldBeFound) {
  EXPECT_THAT(unexplained_in("constexpr int kMost = 3;\n"), testing::ElementsAre("1: kMost"));
  EXPECT_THAT(unexplained_in("// why\n\nconstexpr int kMost = 3;\n"), testing::ElementsAre("3: kMost"));
  EXPECT_THAT(unexplained_in("constexpr int kOne = 1;  // why\nconstexpr int kMost = 3;\n"),
              testing::ElementsAre("2: kMost"));
  EXPECT_THAT(unexplained_in("  static constexpr const char* kNames[] = {\n    \"a\"};\n"),
              testing::ElementsAre("1: kNames"));
  EXPECT_THAT(unexplained_in("// why\nconstexpr int kOne = 1;\nint x;\nconstexpr std::size_t kMost{3};\n"),
              testing::ElementsAre("4: kMost"));

  EXPECT_THAT(unexplained_in("constexpr int kMost = 3;  // why\n"), testing::IsEmpty());
  EXPECT_THAT(unexplained_in("constexpr std::array kMost{1,\n                           2};  // why\n"),
              testing::IsEmpty());
  EXPECT_THAT(unexplained_in("// why\nconstexpr int kOne = 1;\nconstexpr int kMost = 3;\n"), testing::IsEmpty());
  EXPECT_THAT(unexplained_in("constexpr int most(int kOfThem);\nconst int kMost = 3;\nconstexpr int s = 2 * kMost;\n"),
              testing::IsEmpty());
}

}  // namespace
}  // namespace kasumi::house
