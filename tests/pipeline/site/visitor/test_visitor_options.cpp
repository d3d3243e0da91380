// [visitor]: what is read of it, and one message for each mistake.
#include "pipeline/site/visitor/visitor_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kasumi {
namespace {

struct VisitorOfFile {
  std::optional<VisitorOptions> options;
  std::string problems;
};
VisitorOfFile visitor_of(const std::string& text) {
  const auto root = ConfigTable::parse(text, "kasumi.toml").value();
  VisitorOfFile all{read_visitor(root), {}};
  if (const auto done = root.finish(); !done) all.problems = done.error().message;
  return all;
}

TEST(VisitorOptions, AreNoneWithoutTheTable) {
  EXPECT_EQ(visitor_of("").options, std::nullopt);
}

TEST(VisitorOptions, AreDevicesAndKeys) {
  const auto read = visitor_of(
      "[visitor]\ndevices = [\"/dev/input/by-id/usb-A-event-kbd\"]\nthen_and_now = [\"KEY_SPACE\", \"288\"]\n"
      "era = [\"KEY_E\"]\nlanguages = [\"de\", \"ja\"]\nidle_s = 60\n"
      "story = [\"KEY_S\"]\nview = [\"KEY_V\"]\nhints = [\"view\", \"era\"]\nleft_handed = true\nseated = "
      "true\npixels_per_degree = 30\n");
  ASSERT_EQ(read.problems, "");
  EXPECT_EQ(read.options->devices.size(), 1U);
  EXPECT_EQ(read.options->keys[0], (std::vector<int>{57, 288}));
  EXPECT_EQ(read.options->keys[1], std::vector<int>{18});
  EXPECT_EQ(read.options->languages.size(), 2U);
  EXPECT_EQ(read.options->idle, std::chrono::seconds(60));
  EXPECT_EQ(read.options->keys[4], std::vector<int>{31});
  EXPECT_EQ(read.options->keys[5], std::vector<int>{47});
  EXPECT_EQ(read.options->hints, (std::vector<HandKey>{HandKey::view, HandKey::era}));
  EXPECT_EQ(input_key_name(57), "KEY_SPACE");
  EXPECT_EQ(input_key_name(700), "700");
  EXPECT_TRUE(read.options->left_handed && read.options->seated);
  EXPECT_EQ(read.options->pixels_per_degree, 30.0);
}

TEST(VisitorOptions, NameEachMistake) {
  const auto problems = visitor_of(
                            "[visitor]\ndevices = [\"/dev/sda\", \"/dev/input/../sda\"]\nera = [\"KEY_NONE\"]\n"
                            "language = [\"KEY_L\"]\nlarge_print = [\"KEY_L\"]\nlanguages = [\"xx\"]\nidle_s = 1\n"
                            "colour = 3\nhints = [\"wipe\", \"story\", \"language\", \"language\"]\n")
                            .problems;
  for (const auto* said :
       {"visitor.devices", "\"/dev/sda\"", "\"/dev/input/../sda\"", "KEY_NONE", "\"KEY_L\" again", "visitor.languages",
        "visitor.idle_s", "visitor.colour", "not \"wipe\"", "\"story\" has none", "\"language\" again"})
    EXPECT_THAT(problems, testing::HasSubstr(said));
  EXPECT_THAT(visitor_of("[visitor]\nera = [\"KEY_E\"]\n").problems, testing::HasSubstr("visitor.devices"));
}

}  // namespace
}  // namespace kasumi
