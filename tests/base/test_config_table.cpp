#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/config_table.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST(ConfigTable, EveryProblemIsReportedAtOnceWithFileKeyValueAndExpectation) {
  const auto root = ConfigTable::parse("[lens]\nfocal_px = -3\nmodel = 'banana'\ntypo_px = 1\n", "camera.toml").value();
  const auto lens = root.table("lens");
  lens.number("focal_px", {0.1, 1e5});
  lens.choice("model", {"pinhole", "equidistant"});
  lens.numbers("centre_px", 2);
  const auto result = root.finish();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::bad_input);
  EXPECT_THAT(result.error().message,
              HasSubstr("camera.toml: lens.focal_px = -3: expected a number from 0.1 to 100000"));
  EXPECT_THAT(result.error().message, HasSubstr("lens.model = 'banana': expected one of \"pinhole\", \"equidistant\""));
  EXPECT_THAT(result.error().message, HasSubstr("lens.centre_px is missing"));
  EXPECT_THAT(result.error().message, HasSubstr("lens.typo_px: not a key that is known here"));
}

TEST(ConfigTable, AMissingTableIsOneProblemNotOnePerKey) {
  const auto root = ConfigTable::parse("", "a.toml").value();
  const auto lens = root.table("lens");
  lens.number("focal_px");
  lens.text("model");
  const auto result = root.finish();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "a.toml: lens is missing: expected a table [lens]");
}

TEST(ConfigTable, NumbersThatAreNoNumbersAreRefused) {
  for (const char* text : {"a = nan", "a = inf", "a = '1'", "a = true", "a = [1]"}) {
    const auto root = ConfigTable::parse(text, "a.toml").value();
    root.number("a");
    EXPECT_FALSE(root.finish()) << text;
  }
}

TEST(ConfigTable, AWholeNumberIsANumberButNotTheOtherWayRound) {
  const auto root = ConfigTable::parse("a = 3\nb = 3.5", "a.toml").value();
  EXPECT_EQ(root.number("a"), 3.0);
  EXPECT_EQ(root.integer("a"), 3);
  EXPECT_TRUE(ConfigTable::parse("", "x")->finish());
  root.integer("b");
  EXPECT_FALSE(root.finish());
}

TEST(ConfigTable, AValueIsShownAsItWasWritten) {
  const auto root = ConfigTable::parse("a = 134.7", "a.toml").value();
  root.number("a", {0, 100});
  EXPECT_THAT(root.finish().error().message, HasSubstr("a = 134.7: expected"));
}

TEST(ConfigTable, AnIgnoredTableIsSomebodyElsesWithAllBelowIt) {
  const auto root = ConfigTable::parse("a = 1\n[scene]\nb = 2\n[scene.lens]\nc = 3", "a.toml").value();
  root.number("a");
  root.ignore("scene");
  EXPECT_TRUE(root.finish());
}

TEST(ConfigTable, TimeNeedsAnOffset) {
  const auto root = ConfigTable::parse("a = 2003-10-17T12:30:30-07:00\nb = 2003-10-17T12:30:30", "a.toml").value();
  using namespace std::chrono;
  EXPECT_EQ(root.utc("a"), Utc{sys_days{2003y / October / 17} + 19h + 30min + 30s});
  root.utc("b");
  EXPECT_FALSE(root.finish());
}

TEST(ConfigTable, ASyntaxErrorNamesLineAndColumn) {
  const auto result = ConfigTable::parse("a = 1\nb = = 2", "bad.toml");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("bad.toml:2:"));
}

TEST(ConfigTable, ACopyReadsAsTheOriginalButForWhatWasChanged) {
  const auto root = ConfigTable::parse(
                        "top = 1\n[sky]\nwidth = 480\nfocal = 147.64873268436477\nmask = 'a/b.png'\n[sky.camera]\n"
                        "device = '/dev/video0'\n[other]\nkey = 1\n",
                        "a.toml")
                        .value();
  const auto text = root.copy_of({"sky"}, {{"sky.mask", "b \"quoted\".png"}, {"sky.camera", std::nullopt}});
  const auto copy = ConfigTable::parse(text, "copy.toml");
  ASSERT_TRUE(copy) << copy.error().message << text;
  const auto sky = copy->table("sky");
  EXPECT_EQ(sky.integer("width"), 480);
  EXPECT_EQ(sky.number("focal"), 147.64873268436477);
  EXPECT_EQ(sky.text("mask"), "b \"quoted\".png");
  EXPECT_TRUE(copy->finish()) << "nothing else may be left in it:\n" << text;
}

TEST(ConfigTable, CopiesListsOfTables) {
  const auto root =
      ConfigTable::parse("[[peaks]]\nname = 'A'\nheight_m = 1200\n[[peaks]]\nname = 'B'\n[other]\nx = 1\n", "a.toml")
          .value();
  const auto copy = ConfigTable::parse(root.copy_of({"peaks"}, {}), "b.toml").value();
  const auto peaks = copy.tables("peaks");
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_EQ(peaks[0].text("name"), "A");
  EXPECT_EQ(peaks[0].integer("height_m"), 1200);
  EXPECT_EQ(peaks[1].text("name"), "B");
  EXPECT_FALSE(copy.has("other"));
}

TEST(ConfigTable, ItKnowsWhatItWasAskedForAlsoWhatWasNotThere) {
  const auto root = ConfigTable::parse("[lens]\nfocal_px = 1\nmask = 'm.png'\n", "/nowhere/a.toml").value();
  const auto lens = root.table("lens");
  lens.number("focal_px");
  lens.text("model", "pinhole");
  lens.optional_file("mask");
  lens.optional_file("table");
  EXPECT_EQ(root.keys_asked(),
            (std::set<std::string>{"lens", "lens.focal_px", "lens.model", "lens.mask", "lens.table"}));
  EXPECT_EQ(root.files_asked(), (std::map<std::string, std::filesystem::path>{{"lens.mask", "/nowhere/m.png"}}));
}

}  // namespace
}  // namespace kasumi
