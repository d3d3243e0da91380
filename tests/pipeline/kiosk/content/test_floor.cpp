// What comes by itself is never older than what was taken, nor from the future, nor a neighbour's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/content/floor.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using std::chrono::days;

TEST(Floor, IsRaisedAndNeverLoweredButByAPerson) {
  const auto folder = content_folder("floor");
  EXPECT_FALSE(read_floor(folder, std::nullopt));
  ASSERT_TRUE(raise_floor(folder, kMonday, std::nullopt));
  ASSERT_TRUE(raise_floor(folder, kMonday - days(9), std::nullopt));
  EXPECT_EQ(read_floor(folder, std::nullopt), kMonday);
  ASSERT_TRUE(set_floor(folder, kMonday - days(9)));
  EXPECT_EQ(read_floor(folder, std::nullopt), kMonday - days(9));
  EXPECT_FALSE(read_floor(folder, kMonday - days(10))) << "believed by a clock that was wrong";
  for (const char* text : {"", "x", "2026-13-01T00:00:00Z"}) {
    ASSERT_TRUE(write_text_file(folder / "floor", text));
    EXPECT_FALSE(read_floor(folder, std::nullopt)) << text;
  }
}

TEST(Floor, WhatMayBeBelievedDependsOnTheClock) {
  EXPECT_EQ(latest_believable(kMonday, true), kMonday + days(1));
  EXPECT_EQ(latest_believable(kMonday, false), kMonday + days(366));
  EXPECT_FALSE(latest_believable(Utc{}, false)) << "nothing, by a clock at 1970";
}

struct Replayed : testing::Test {
  Replayed() : folder(content_folder("replayed")), generations(folder / "content") {}
  fs::path bundle(const std::string& name, Utc made, std::vector<std::string> kiosks = {}) {
    const auto desk = folder / ("desk-" + name);
    fs::remove_all(desk);
    const auto config = write_desk(desk / "files");
    const auto out = folder / (name + kBundleExtension);
    const auto done = pack({config, out, name, made, std::nullopt, {}, std::move(kiosks)});
    EXPECT_TRUE(done) << done.error().message;
    return out;
  }
  Result<Installed> newer(const fs::path& file, Utc now = kMonday) {
    auto rules = kUnsigned;
    rules.newer_only = true;
    rules.kiosk = "hill";
    return install_file(file, generations, now, rules);
  }
  fs::path folder;
  Generations generations;
};

TEST_F(Replayed, Row46AfterGoingBackAnOlderBundleIsStillRefused) {
  const auto one = bundle("one", kMonday - days(90)), two = bundle("two", kMonday - days(60)),
             three = bundle("three", kMonday - days(30));
  ASSERT_EQ(newer(two)->left_alone, "");
  ASSERT_EQ(newer(three)->left_alone, "");
  ASSERT_TRUE(generations.go_back(generations.current()->id, kMonday, "by hand"));
  EXPECT_THAT(newer(one)->left_alone, HasSubstr("not newer than what was taken before"));
  EXPECT_THAT(newer(two)->left_alone, HasSubstr("not newer than what was taken before"));
  EXPECT_THAT(newer(three)->left_alone, HasSubstr("went back"));
  ASSERT_TRUE(set_floor(generations.folder(), kMonday - days(61)));
  EXPECT_EQ(newer(two)->left_alone, "") << "once a person has let it in";
}

TEST_F(Replayed, Row46AFloorThatTheDiskLostIsThatOfWhatIsStillThere) {
  const auto one = bundle("one", kMonday - days(90)), two = bundle("two", kMonday - days(60)),
             three = bundle("three", kMonday - days(30));
  ASSERT_EQ(newer(two)->left_alone, "");
  ASSERT_EQ(newer(three)->left_alone, "");
  ASSERT_TRUE(generations.go_back(generations.current()->id, kMonday, "by hand"));
  for (const char* damage : {"", "\xff\xff"}) {
    ASSERT_TRUE(write_text_file(generations.folder() / "floor", damage));
    EXPECT_THAT(newer(one)->left_alone, HasSubstr("not newer than what was taken before"));
  }
  ASSERT_TRUE(install_file(one, generations, kMonday, kUnsigned)) << "by hand";
  EXPECT_EQ(read_floor(generations.folder(), std::nullopt), kMonday - days(30)) << "and it is no lower then";
}

TEST_F(Replayed, Row46ADateThatHasNotComeIsRefusedAndShutsNobodyOut) {
  const auto future = bundle("future", kMonday + days(20'000)), good = bundle("good", kMonday - days(1));
  EXPECT_THAT(newer(future), FailsWith(HasSubstr("has not come yet")));
  // Taken at a time when the clock knew nothing.
  auto rules = kUnsigned;
  rules.clock_trusted = false;
  ASSERT_TRUE(install_file(future, generations, Utc{}, rules));
  EXPECT_EQ(newer(good)->left_alone, "");
}

TEST_F(Replayed, Row46ABundleForOtherKiosksIsRefused) {
  const auto theirs = newer(bundle("theirs", kMonday - days(2), {"valley", "shore"}));
  ASSERT_FALSE(theirs);
  EXPECT_THAT(theirs.error().message, HasSubstr("is for valley, shore, and this kiosk is \"hill\""));
  EXPECT_TRUE(newer(bundle("ours", kMonday - days(1), {"hill"})));
}

TEST(Manifest, Row46ItsOwnNamesAreNoFoldersEither) {
  const auto folder = content_folder("own-names");
  for (const char* own : {"manifest.json/x", "manifest.json.minisig/x"}) {
    auto manifest = write_files(folder, {{"kasumi.toml", "a"}});
    manifest.files.push_back({own, 1, sha256_of("x")});
    EXPECT_THAT(parse_manifest(manifest_text(manifest)), FailsWith(HasSubstr("which is the bundle's own")));
  }
}

}  // namespace
}  // namespace kasumi
