// Generations on a disk: which is shown, what becomes of each, what they go back to.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/content/generations.hpp"
#include "tests/pipeline/kiosk/content/bundles.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
namespace fs = std::filesystem;

constexpr Utc kMonday = std::chrono::sys_days{std::chrono::June / 1 / 2026};

// As an installation does it, without a bundle. Returns its id.
std::string add(const Generations& generations, const std::string& name, Utc now) {
  const auto folder = generations.new_folder().value();
  const auto manifest = write_files(folder, {{"kasumi.toml", "# " + name + "\n"}}, name);
  const auto text = manifest_text(manifest);
  EXPECT_TRUE(write_text_file(folder / kManifestName, text));
  Generation generation{.id = content_id(text), .manifest = manifest, .installed = now, .signed_by = "curator"};
  EXPECT_TRUE(generations.add(folder, generation));
  return generation.id;
}

std::vector<std::string> names_of(const std::vector<Generation>& all) {
  std::vector<std::string> names;
  for (const auto& each : all) names.push_back(each.manifest.name);
  return names;
}

struct Shelf : testing::Test {
  Shelf() : folder(content_folder("generations")), generations(folder / "content") {}
  std::string shown() const {
    const auto current = generations.current();
    return current ? current->manifest.name : "by hand";
  }
  std::string install(const std::string& name, Utc now) {
    const auto id = add(generations, name, now);
    EXPECT_TRUE(generations.show(&id));
    return id;
  }
  fs::path folder;
  Generations generations;
};

TEST_F(Shelf, WithoutAnyTheConfigurationSetUpByHandIsShown) {
  EXPECT_EQ(shown(), "by hand");
  EXPECT_TRUE(generations.all().empty());
  const ContentPlace place{"/etc/kasumi/kasumi.toml", generations};
  EXPECT_EQ(place.configuration(), "/etc/kasumi/kasumi.toml");
  EXPECT_EQ((ContentPlace{"/etc/kasumi/kasumi.toml"}).configuration(), "/etc/kasumi/kasumi.toml");
}

TEST_F(Shelf, TheLinkAloneDecides) {
  const auto spring = install("Spring", kMonday), summer = add(generations, "Summer", kMonday + 1h);
  EXPECT_EQ(shown(), "Spring") << "summer is there, but not shown yet";
  EXPECT_TRUE(generations.show(&summer));
  EXPECT_EQ(shown(), "Summer");
  EXPECT_EQ(fs::read_symlink(folder / "content/current"), summer) << "relative: the folder may move";
  EXPECT_THAT(names_of(generations.all()), ElementsAre("Summer", "Spring"));
  const ContentPlace place{"/etc/kasumi/kasumi.toml", generations};
  EXPECT_EQ(place.configuration(), folder / "content" / summer / "kasumi.toml") << "through no link that may move";
  EXPECT_EQ(generations.of(place.configuration())->id, summer);
  EXPECT_FALSE(generations.of("/etc/kasumi/kasumi.toml"));
  EXPECT_TRUE(generations.show(nullptr));
  EXPECT_EQ(shown(), "by hand");
}

TEST_F(Shelf, ASlashAtTheEndOfItsNameChangesNothing) {
  const auto spring = install("Spring", kMonday);
  const Generations named((folder / "content").string() + "/");
  const auto shown_now = named.of(named.config_of(*named.current()));
  ASSERT_TRUE(shown_now);
  EXPECT_EQ(shown_now->id, spring);
  EXPECT_TRUE(generations.of(named.config_of(*named.current())));
}

TEST_F(Shelf, GoesBackToWhatWasProvenLast) {
  const auto spring = install("Spring", kMonday);
  EXPECT_TRUE(generations.current()->on_probation());
  ASSERT_TRUE(generations.note_proven(spring, kMonday + 10min));
  EXPECT_FALSE(generations.current()->on_probation());
  const auto summer = install("Summer", kMonday + 1h);
  ASSERT_TRUE(generations.note_proven(summer, kMonday + 2h));
  const auto autumn = install("Autumn", kMonday + 3h);
  ASSERT_TRUE(generations.go_back(autumn, kMonday + 4h, "no pictures"));
  EXPECT_EQ(shown(), "Summer");
  EXPECT_EQ(generations.find(autumn)->went_back->why, "no pictures");
  EXPECT_EQ(generations.find(autumn)->went_back->utc, kMonday + 4h);
  ASSERT_TRUE(generations.go_back(summer, kMonday + 5h, "by hand"));
  EXPECT_EQ(shown(), "Spring") << "not to autumn, which was never proven, nor round in circles";
  ASSERT_TRUE(generations.go_back(spring, kMonday + 6h, "by hand"));
  EXPECT_EQ(shown(), "by hand");
  ASSERT_TRUE(generations.show(&summer));
  EXPECT_FALSE(generations.current()->went_back) << "asked for again";
  EXPECT_FALSE(generations.current()->on_probation()) << "it has served that";
}

TEST_F(Shelf, AnotherOneThanIsShownGoesBackWithoutTheScreen) {
  const auto spring = install("Spring", kMonday), summer = install("Summer", kMonday + 1h);
  ASSERT_TRUE(generations.go_back(spring, kMonday + 2h, "too late"));
  EXPECT_EQ(shown(), "Summer");
}

TEST_F(Shelf, StartsOnProbationAreCountedAndForgiven) {
  const auto spring = install("Spring", kMonday);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(generations.note_start(spring));
  ASSERT_TRUE(generations.note_failed_before(spring, {"sky_camera.open"}));
  EXPECT_EQ(generations.current()->starts, 3);
  EXPECT_THAT(generations.current()->failed_before, ElementsAre("sky_camera.open"));
  ASSERT_TRUE(generations.note_proven(spring, kMonday));
  EXPECT_EQ(generations.current()->starts, 0);
  EXPECT_FALSE(generations.note_start("0123456789abcdef"));
}

TEST_F(Shelf, FoundByTheFirstDigits) {
  const auto spring = install("Spring", kMonday);
  EXPECT_EQ(generations.find(spring.substr(0, 5))->id, spring);
  EXPECT_FALSE(generations.find("xyz"));
  install("Summer", kMonday);
  EXPECT_FALSE(generations.find("")) << "several";
}

TEST_F(Shelf, DamageIsLeftOutAndCannotLeadAway) {
  const auto spring = install("Spring", kMonday);
  ASSERT_TRUE(generations.note_proven(spring, kMonday));
  const auto summer = install("Summer", kMonday + 1h);
  ASSERT_TRUE(write_text_file(folder / "content" / summer / kManifestName, "{"));
  EXPECT_EQ(shown(), "Spring") << "the one before";
  for (const char* record : {"", "[", "{\"starts\": -4, \"failed_before\": 3, \"proven_utc\": 7}", "7"}) {
    ASSERT_TRUE(write_text_file(folder / "content" / (spring + ".json"), record));
    ASSERT_TRUE(generations.find(spring)) << record;
    EXPECT_TRUE(generations.find(spring)->on_probation());
  }
  for (const char* target : {"/etc", "../..", "nothing", ".."}) {
    fs::remove(folder / "content/current");
    fs::create_symlink(target, folder / "content/current");
    EXPECT_EQ(shown(), "by hand") << target;
  }
}

TEST_F(Shelf, OldOnesMakeRoomButNeverWhatMayBeNeeded) {
  const auto proven = install("0", kMonday);
  ASSERT_TRUE(generations.note_proven(proven, kMonday));
  for (int i = 1; i < 7; ++i) {
    const auto id = install(std::to_string(i), kMonday + i * 1h);
    if (i < 6) {
      ASSERT_TRUE(generations.go_back(id, kMonday + i * 1h + 1min, "no"));
    }
    generations.prune();
  }
  EXPECT_THAT(names_of(generations.all()), ElementsAre("6", "5", "0")) << "shown, the newest, what it goes back to";
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& each : fs::directory_iterator(folder / "content")) ++entries;
  EXPECT_EQ(entries, 3u + 3u + 2u) << "three folders with their records, the link, the lock";
}

TEST_F(Shelf, LeftoversOfAPowerCutAreSweptByTheNextInstallation) {
  fs::create_directories(folder / "content/.unpack.999999999/models");
  fs::create_directories(folder / "content/.unpack.999999999-0123456789abcdef");
  install("Spring", kMonday);
  EXPECT_FALSE(fs::exists(folder / "content/.unpack.999999999"));
  EXPECT_FALSE(fs::exists(folder / "content/.unpack.999999999-0123456789abcdef"));
}

}  // namespace
}  // namespace kasumi
