#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/ranges.h>

#include "base/outside/lines.hpp"
#include "base/table/config_table.hpp"
#include "tests/must.hpp"

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
  EXPECT_THAT(result.error().message, HasSubstr("lens.typo_px: unknown key"));
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

TEST(ConfigTable, WhatSeveralReadersMissIsToldOnce) {
  const auto root = ConfigTable::parse("width = -1\nheight = -1\n", "a.toml").value();
  for (int reader = 0; reader < 3; ++reader) {
    root.table("site");
    root.number("width", {0, 10});
    root.number("height", {0, 10});
  }
  const auto result = root.finish();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message,
            "a.toml: site is missing: expected a table [site]\na.toml: width = -1: expected a number from 0 to 10\n"
            "a.toml: height = -1: expected a number from 0 to 10");
}

TEST(Problems, AreToldOnceEachInTheirOrder) {
  Problems of_sky, of_scene, all;
  of_sky.add("a.toml: site is missing");
  of_sky.add("a.toml: sky is missing");
  of_scene.add("a.toml: site is missing");
  of_scene.add("a.toml: scene is missing");
  all.add("{}", of_sky.fault().message);
  all.add("{}", of_scene.fault().message);
  EXPECT_EQ(all.fault().message, "a.toml: site is missing\na.toml: sky is missing\na.toml: scene is missing");
}

TEST(Problems, WhatALineAnnouncesStaysWithIt) {
  Problems problems;
  for (const char* camera : {"sky", "scene", "sky"})
    problems.add("{}.sensitivity: expected one that can be read:\nb.csv: line 3", camera);
  EXPECT_EQ(problems.fault().message,
            "sky.sensitivity: expected one that can be read:\nb.csv: line 3\n"
            "scene.sensitivity: expected one that can be read:\nb.csv: line 3");
}

// In lists, which count: one refused file is one problem, not one and another.
TEST(Problems, WhatALineAnnouncesIsOneProblemWithIt) {
  EXPECT_THAT(
      lines_of("a.toml: calibration = 'b.toml': expected a file that kasumi calibrate wrote:\nb.toml:1: not TOML\n"
               "a.toml: nonsense: unknown key"),
      testing::ElementsAre(
          "a.toml: calibration = 'b.toml': expected a file that kasumi calibrate wrote: b.toml:1: not TOML",
          "a.toml: nonsense: unknown key"));
  EXPECT_THAT(lines_of(""), testing::IsEmpty());
}

// A status with all of them was too large for its readers: the kiosk was unknown to them, and could not be reloaded.
TEST(Problems, Row23OfVeryManyTheFirstAreListed) {
  std::string text(1000, 'x');
  text += "\n\x1b[2J\n" + std::string(399, 'y') + "\u00e9\n";
  for (int i = 0; i < 60'000; ++i) text += fmt::format("a.toml: k{}: unknown key\n", i);
  const auto lines = lines_of(text);
  ASSERT_EQ(lines.size(), kMostProblems + 1);
  EXPECT_EQ(lines[0], std::string(400, 'x') + "...");
  EXPECT_EQ(lines[1], " [2J");
  EXPECT_EQ(lines[2], std::string(399, 'y') + "...") << "whole characters";
  EXPECT_EQ(lines[3], "a.toml: k0: unknown key");
  EXPECT_EQ(lines.back(), fmt::format("and {} more", 60'000 - (kMostProblems - 3)));
}

TEST(ConfigTable, ValuesThatAreNotFiniteNumbersAreRefused) {
  for (const char* text : {"a = nan", "a = inf", "a = '1'", "a = true", "a = [1]"}) {
    const auto root = ConfigTable::parse(text, "a.toml").value();
    root.number("a");
    EXPECT_FALSE(root.finish()) << text;
  }
  for (const char* text : {"a = nan", "a = -inf", "a = [nan]", "a = [1.0, nan]"}) {
    const auto root = ConfigTable::parse(text, "a.toml").value();
    EXPECT_EQ(root.if_number("a"), std::nullopt) << text;
    root.integer("a");
    root.numbers("a", 0);
    ASSERT_FALSE(root.finish()) << text;
    EXPECT_THAT(root.finish().error().message, testing::AllOf(HasSubstr("whole number"), HasSubstr("list of numbers")));
  }
}

TEST(ConfigTable, AnIntegerIsANumberButNotTheOtherWayRound) {
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

TEST(ConfigTable, AnIgnoredTableIsIgnoredWithAllItsSubtables) {
  const auto root = ConfigTable::parse("a = 1\n[scene]\nb = 2\n[scene.lens]\nc = 3", "a.toml").value();
  root.number("a");
  root.ignore("scene");
  EXPECT_TRUE(root.finish());
}

TEST(ConfigTable, AnIgnoredListOfTablesIsIgnoredToo) {
  const auto root = ConfigTable::parse("[[landmarks]]\na = 1\n[[landmarks]]\nb = {c = 2}\n[other]", "a.toml").value();
  root.ignore("landmarks");
  const auto whole = root.finish();
  ASSERT_FALSE(whole);
  EXPECT_EQ(whole.error().message, "a.toml: other: unknown key");
}

TEST(ConfigTable, AnUnknownTableCanBePrintedAndListsOfStringsAreRead) {
  const auto root = ConfigTable::parse("b = 2\na = 'x'\nc = ['p', 'q']\nd = ['p', 3]\n", "a.toml").value();
  EXPECT_THAT(root.keys(), testing::ElementsAre("a", "b", "c", "d"));
  EXPECT_EQ(root.if_number("b"), 2.0);
  EXPECT_EQ(root.if_number("a"), std::nullopt);
  EXPECT_EQ(root.if_text("a"), "x");
  EXPECT_THAT(root.texts("c"), testing::ElementsAre("p", "q"));
  EXPECT_THAT(root.texts("missing"), testing::IsEmpty());
  root.texts("d");
  EXPECT_EQ(root.finish().error().message, "a.toml: d = [ 'p', 3 ]: expected a list of texts in quotes");
}

TEST(ConfigTable, TimeNeedsAnOffset) {
  const auto root = ConfigTable::parse("a = 2003-10-17T12:30:30-07:00\nb = 2003-10-17T12:30:30", "a.toml").value();
  using namespace std::chrono;
  EXPECT_EQ(root.utc("a"), Utc{sys_days{2003y / October / 17} + 19h + 30min + 30s});
  root.utc("b");
  EXPECT_FALSE(root.finish());
}

TEST(ConfigTable, ASyntaxErrorNamesLineAndColumn) {
  EXPECT_THAT(ConfigTable::parse("a = 1\nb = = 2", "bad.toml"), FailsWith(HasSubstr("bad.toml:2:")));
}

std::string dotted(int parts) {
  std::string key = "a";
  for (int i = 1; i < parts; ++i) key += i % 2 == 0 ? ".a" : " . \"a\"";
  return key;
}

// A megabyte of them would overflow the parser's stack.
TEST(ConfigTable, AKeyOfManyPartsIsRefused) {
  const std::string deep = dotted(17);
  for (const std::string& text : {deep + " = 1", "[" + deep + "]", "[[" + deep + "]]",
                                  "a = [{b = 1.5, " + deep + " = 1}]", "a = {b = \"\"\"\\\"\"\"\"\", " + deep + " = 1}",
                                  "a = {b = '''''''', " + deep + " = 1}", "a = 'b\\' # '\n" + deep + " = 1"}) {
    const auto root = ConfigTable::parse(text, "a.toml");
    ASSERT_FALSE(root) << text;
    EXPECT_EQ(root.error().message, "a.toml: a key of 17 parts: expected 16 at most");
  }
  EXPECT_FALSE(ConfigTable::parse(dotted(400'000) + " = 1", "a.toml"));
  EXPECT_TRUE(ConfigTable::parse("[" + dotted(16) + "]", "a.toml"));
}

TEST(ConfigTable, DotsThatPartNoKeyDoNotCount) {
  const std::string dots(100, '.');
  for (const std::string& text :
       {"# " + dots, "a = \"" + dots + "\\\"" + dots + "\" # " + dots, "'" + dots + "' = '" + dots + "'",
        "a = \"\"\"" + dots + "\n\"\"" + dots + "\\\"\"\"\"\"\" # " + dots, "a = '''" + dots + "''\n" + dots + "''''",
        fmt::format("a = [{:.1f}]", fmt::join(std::vector<double>(100, 1.5), ", "))}) {
    const auto root = ConfigTable::parse(text, "a.toml");
    EXPECT_TRUE(root) << text << ": " << root.error().message;
  }
}

TEST(ConfigTable, ACopyReadsAsTheOriginalExceptForTheChanges) {
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

TEST(ConfigTable, RemembersEveryRequestedKeyEvenIfAbsent) {
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

TEST(ConfigTable, ItsOwnKeysOverrideAdoptedOnesKeyByKey) {
  const auto root =
      ConfigTable::parse("[sky]\nwidth = 480\nazimuth_up_deg = 3\n[sky.lens]\nmodel = 'a'\n", "here/a.toml").value();
  const auto other = ConfigTable::parse(
                         "[site]\nlatitude_deg = 46\n[sky]\nwidth = 640\nheading_deg = 5\nmask = 'm.png'\n[sky.lens]\n"
                         "model = 'b'\nfocal_px = 7\n[sky.noise]\nread = -1\n",
                         "there/b.toml")
                         .value();
  const auto site = root.adopt(other, "site");
  const auto sky = root.adopt(other, "sky", {{"azimuth_up_deg", "heading_deg"}});
  EXPECT_THAT(site.gained, testing::ElementsAre("site.latitude_deg"));
  EXPECT_THAT(sky.gained, testing::ElementsAre("sky.mask", "sky.noise"));
  EXPECT_THAT(sky.overruled, testing::UnorderedElementsAre("sky.width", "sky.heading_deg", "sky.lens"));
  EXPECT_EQ(root.table("site").number("latitude_deg"), 46.0);
  const auto table = root.table("sky");
  EXPECT_EQ(table.integer("width"), 480);
  EXPECT_FALSE(table.has("heading_deg"));
  EXPECT_EQ(table.table("lens").text("model"), "a");
  EXPECT_FALSE(table.table("lens").has("focal_px")) << "a lens is taken as a whole, never mixed";
}

TEST(ConfigTable, ProblemsNameTheFileOfTheWrongValue) {
  const auto root = ConfigTable::parse("[sky]\nwidth = -1\n", "here/a.toml").value();
  const auto other =
      ConfigTable::parse("[sky]\nmask = 'm.png'\ntypo = 1\n[sky.noise]\nread = -1\n", "there/b.toml").value();
  root.adopt(other, "sky");
  const auto sky = root.table("sky");
  sky.number("width", {0, 10});
  sky.number("height");
  sky.file("mask");
  sky.table("noise").number("read", {0, 10});
  sky.table("noise").number("full");
  EXPECT_EQ(root.files_asked().at("sky.mask"), std::filesystem::path("there/m.png"));
  const auto whole = root.finish();
  ASSERT_FALSE(whole);
  for (const char* part : {"here/a.toml: sky.width = -1", "here/a.toml: sky.height is missing",
                           "there/b.toml: sky.mask = ", "looked for there/m.png", "there/b.toml: sky.noise.read = -1",
                           "there/b.toml: sky.noise.full is missing", "there/b.toml: sky.typo: unknown key"})
    EXPECT_THAT(whole.error().message, HasSubstr(part));
}

TEST(ConfigTable, ACopyOfAdoptedTablesIsSelfContained) {
  const auto root = ConfigTable::parse("[sky]\nwidth = 480\n", "here/a.toml").value();
  const auto other = ConfigTable::parse("[sky]\nheight = 360\n[sky.lens]\nmodel = 'b'\n", "there/b.toml").value();
  root.adopt(other, "sky");
  const auto copy = ConfigTable::parse(root.copy_of({"sky"}, {}), "copy.toml").value();
  EXPECT_EQ(copy.table("sky").integer("width"), 480);
  EXPECT_EQ(copy.table("sky").integer("height"), 360);
  EXPECT_EQ(copy.table("sky").table("lens").text("model"), "b");
}

TEST(ConfigTable, MissingKeysAreExcusedAndWrongOnesAreNot) {
  const auto root = ConfigTable::parse("calibration = 'gone.toml'\n[sky]\nwidth = -1\n", "a.toml").value();
  root.file("calibration");
  root.excuse_missing();
  root.table("sky").number("width", {0, 10});
  root.table("sky").number("height");
  root.table("scene").number("width");
  const auto whole = root.finish();
  ASSERT_FALSE(whole);
  EXPECT_THAT(whole.error().message, HasSubstr("gone.toml"));
  EXPECT_THAT(whole.error().message, HasSubstr("sky.width = -1"));
  EXPECT_THAT(whole.error().message, testing::Not(HasSubstr("missing")));
}

// Keys of a table whose file is missing were never asked for, whatever they are.
TEST(ConfigTable, OneMissingFileIsOneProblem) {
  const auto root =
      ConfigTable::parse("[scene]\ncalibration = \"gone.toml\"\nmask_px = 3\n[sky]\nb = 1\n", "a.toml").value();
  root.table("scene").file("calibration");
  root.table("sky");
  EXPECT_EQ(root.finish().error().message,
            "a.toml: scene.calibration = 'gone.toml': expected an existing file (looked for gone.toml)\n"
            "a.toml: sky.b: unknown key");
}

}  // namespace
}  // namespace kasumi
