// Which content a start shows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/content/content_at_start.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

// A kiosk with a configuration set up by hand, and generations beside it.
struct Starting : testing::Test {
  Starting()
      : folder(content_folder("start")),
        by_hand(write_desk(folder / "etc")),
        generations(folder / "content"),
        place{by_hand, generations} {}
  // Installs content that says so in its caption.
  std::string install(const std::string& name, Utc at) {
    fs::remove_all(folder / "desk");
    const auto config = write_desk(folder / "desk");
    replace_in(config, "The view returns in a moment.", name);
    const auto installed = install_file(packed(config, name, at), generations, at);
    EXPECT_TRUE(installed) << installed.error().message;
    return installed ? installed->generation.id : "";
  }
  std::string proven(const std::string& name, Utc at) {
    const auto id = install(name, at);
    EXPECT_TRUE(generations.note_proven(id, at + 10min));
    return id;
  }
  ContentPtr start() {
    StartLog starts({}, "boot", 15.0);
    auto content = content_at_start(place, starts, folder / "last-good", kMonday);
    if (!content) {
      ADD_FAILURE() << content.error().message;
      return std::make_shared<Content>();
    }
    return *content;
  }
  std::string caption() { return start()->config.still.caption; }
  void damage(const std::string& id) {
    const auto file = folder / "content" / id / "kasumi.toml";
    ASSERT_TRUE(write_text_file(file, "nonsense = 1\n" + read_text_file(file).value()));
  }
  fs::path folder, by_hand;
  Generations generations;
  ContentPlace place;
};

TEST_F(Starting, TheCurrentGenerationGoesBeforeTheConfigurationSetUpByHand) {
  EXPECT_EQ(caption(), "The view returns in a moment.");
  proven("Spring", kMonday);
  EXPECT_EQ(caption(), "Spring");
  EXPECT_EQ(generations.current()->starts, 0) << "no probation, nothing to count";
}

TEST_F(Starting, Row22WhatIsRefusedOnProbationGoesBackForGood) {
  proven("Spring", kMonday);
  const auto summer = install("Summer", kMonday + 1h);
  damage(summer);
  const auto content = start();
  EXPECT_EQ(content->config.still.caption, "Spring");
  EXPECT_FALSE(content->instead) << "spring is what is configured now";
  EXPECT_THAT(generations.find(summer)->went_back->why, HasSubstr("nonsense"));
  EXPECT_EQ(generations.current()->manifest.name, "Spring");
}

TEST_F(Starting, FiveFailedStartsOfNewContentAreEnough) {
  proven("Spring", kMonday);
  const auto summer = install("Summer", kMonday + 1h);
  for (int i = 0; i < kStartsBeforeKeptContent; ++i) EXPECT_EQ(caption(), "Summer") << i;
  EXPECT_EQ(caption(), "Spring");
  EXPECT_THAT(generations.find(summer)->went_back->why, HasSubstr("starts in a row have failed"));
}

TEST_F(Starting, ProvenContentIsNotGivenUpForWhatMayPass) {
  proven("Spring", kMonday);
  const auto summer = proven("Summer", kMonday + 1h);
  damage(summer);
  const auto content = start();
  EXPECT_EQ(content->config.still.caption, "Spring");
  ASSERT_TRUE(content->instead);
  EXPECT_THAT(content->instead->refused.front(), HasSubstr("nonsense"));
  EXPECT_EQ(generations.current()->id, summer) << "a disk, or an update that did not know a key: it is tried again";
  make_unreadable(folder / "content" / summer / "kasumi.toml");
  EXPECT_EQ(caption(), "Spring");
}

TEST_F(Starting, ADiskThatFailsIsNoReasonToGoBack) {
  proven("Spring", kMonday);
  const auto summer = install("Summer", kMonday + 1h);
  make_unreadable(folder / "content" / summer / "kasumi.toml");
  const auto content = start();
  EXPECT_EQ(content->config.still.caption, "Spring");
  EXPECT_TRUE(content->instead);
  EXPECT_EQ(generations.current()->id, summer);
}

TEST_F(Starting, TheFirstGenerationGoesBackToWhatWasSetUpByHand) {
  const auto spring = install("Spring", kMonday);
  damage(spring);
  EXPECT_EQ(caption(), "The view returns in a moment.");
  EXPECT_FALSE(generations.current());
}

TEST_F(Starting, AndToTheCopiesOfThatIfItIsRefusedToo) {
  ASSERT_TRUE(keep_content(*read_content(by_hand).value(), folder / "last-good", kMonday));
  ASSERT_TRUE(write_text_file(by_hand, "nonsense = 2\n" + read_text_file(by_hand).value()));
  damage(install("Spring", kMonday));
  const auto content = start();
  EXPECT_EQ(content->config.still.caption, "The view returns in a moment.");
  ASSERT_TRUE(content->instead);
  EXPECT_THAT(content->instead->refused.front(), HasSubstr("nonsense"));
}

TEST_F(Starting, WithNothingBeforeItContentThatFailsIsShownAllTheSame) {
  fs::remove(by_hand);
  install("Spring", kMonday);
  for (int i = 0; i < 2 * kStartsBeforeKeptContent; ++i) EXPECT_EQ(caption(), "Spring");
}

// The power went between the note and the link.
TEST_F(Starting, WhatHadBegunToGoBackHasGoneBack) {
  const auto spring = proven("Spring", kMonday), summer = proven("Summer", kMonday + 1h);
  ASSERT_TRUE(generations.go_back(summer, kMonday + 2h, "by hand"));
  fs::remove(folder / "content/current");
  fs::create_symlink(summer, folder / "content/current");
  const auto content = start();
  EXPECT_EQ(content->config.still.caption, "Spring");
  EXPECT_FALSE(content->instead);
  EXPECT_EQ(generations.current()->id, spring);
}

// A file of a bundle that is what it says, but is no content.
TEST_F(Starting, AnInstallationThatAStartWouldRefuseChangesNothing) {
  const auto spring = proven("Spring", kMonday);
  fs::create_directories(folder / "bad");
  auto manifest = write_files(folder / "bad", {{"kasumi.toml", "nonsense = 1\n[site]\nlatitude_deg = 95\n"}}, "Bad");
  ASSERT_TRUE(write_bundle(folder / "bad.kasumi", folder / "bad", manifest, ""));
  const auto refused = install_file(folder / "bad.kasumi", generations, kMonday);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("bad.kasumi: kasumi.toml: "), HasSubstr("nonsense"),
                                                      HasSubstr("site.latitude_deg")))
      << "all problems at once, named as in the bundle";
  EXPECT_EQ(generations.current()->id, spring);
  EXPECT_EQ(generations.all().size(), 1u);
}

TEST_F(Starting, WhatWentBackIsNotInstalledAgainUnlessAskedFor) {
  proven("Spring", kMonday);
  const auto summer = install("Summer", kMonday + 1h);
  const auto bundle = folder / "Summer.kasumi";
  EXPECT_EQ(install_file(bundle, generations, kMonday)->left_alone, "it is shown already");
  ASSERT_TRUE(generations.go_back(summer, kMonday, "dark"));
  EXPECT_THAT(install_file(bundle, generations, kMonday),
              FailsWith(testing::AllOf(HasSubstr("dark"), HasSubstr("--again"))));
  auto rules = kUnsigned;
  rules.newer_only = true;  // a stick that stays in the machine
  EXPECT_THAT(install_file(bundle, generations, kMonday, rules)->left_alone, HasSubstr("dark"));
  rules = kUnsigned;
  rules.again = true;
  EXPECT_EQ(install_file(bundle, generations, kMonday, rules)->left_alone, "");
  EXPECT_TRUE(generations.current()->on_probation());
}

TEST_F(Starting, OnlyNewerContentReplacesByItself) {
  proven("Summer", kMonday + 1h);
  const auto config = write_desk(folder / "older");
  auto rules = kUnsigned;
  rules.newer_only = true;
  const auto left = must(install_file(packed(config, "Spring", kMonday), generations, kMonday, rules));
  EXPECT_THAT(left->left_alone, HasSubstr("not newer"));
  EXPECT_EQ(install_file(folder / "Spring.kasumi", generations, kMonday)->left_alone, "") << "by hand it does";
}

// Of two bundles of one moment, one on a stick and one in a folder, each would replace the other whenever it is looked at.
TEST_F(Starting, ContentOfTheSameMomentDoesNotReplaceByItself) {
  proven("Summer", kMonday);
  const auto config = write_desk(folder / "beside");
  auto rules = kUnsigned;
  rules.newer_only = true;
  const auto left = must(install_file(packed(config, "Spring", kMonday), generations, kMonday, rules));
  EXPECT_THAT(left->left_alone, HasSubstr("not newer"));
  EXPECT_EQ(generations.current()->manifest.name, "Summer");
  const auto newer = must(install_file(packed(config, "Autumn", kMonday + 1s), generations, kMonday, rules));
  EXPECT_EQ(newer->left_alone, "");
}

TEST_F(Starting, Row21WithoutRoomOnTheDiskNothingIsUnpacked) {
  const auto spring = proven("Spring", kMonday);
  const auto trusted = must(open_trusted(packed(write_desk(folder / "desk"), "Summer", kMonday + 1h), kUnsigned));
  const auto needed = trusted->bundle.manifest.bytes() + kContentLeavesFree;
  const auto install_with = [&](std::uint64_t left) {
    return kasumi::install(*trusted, generations, kUnsigned, kMonday + 1h, [&, left](const fs::path& asked) {
      EXPECT_EQ(asked, generations.folder()) << "of the disk that is filled";
      return Result<std::uint64_t>(left);
    });
  };
  const auto refused = install_with(needed - 1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::io) << "it is tried again";
  EXPECT_THAT(refused.error().message, HasSubstr("MB are needed"));
  EXPECT_EQ(generations.all().size(), 1u);
  EXPECT_EQ(generations.current()->id, spring);
  const auto done = must(install_with(needed));
  EXPECT_EQ(generations.current()->manifest.name, "Summer");
}

TEST_F(Starting, OfAFolderTheNewestIsTaken) {
  const auto config = write_desk(folder / "desk");
  fs::create_directories(folder / "stick");
  for (const auto& [name, at] : {std::pair{"Spring", kMonday}, {"Summer", kMonday + 2h}, {"May", kMonday + 1h}})
    fs::rename(packed(config, name, at), folder / "stick" / (std::string(name) + ".kasumi"));
  ASSERT_TRUE(write_text_file(folder / "stick/broken.kasumi", "x"));
  ASSERT_TRUE(install_file(folder / "stick", generations, kMonday));
  EXPECT_EQ(generations.current()->manifest.name, "Summer");
  fs::create_directories(folder / "empty");
  EXPECT_THAT(install_file(folder / "empty", generations, kMonday).error().message, HasSubstr("no bundle in it"));
}

// A mistake is named before it leaves the desk.
TEST_F(Starting, PackingNamesWhatAKioskWouldRefuse) {
  const auto config = write_desk(folder / "desk");
  const auto out = folder / "out.kasumi";
  const auto why = [&] {
    const auto done = pack({config, out, "x", kMonday, std::nullopt, {}});
    return done ? "packed" : done.error().message;
  };
  const auto good = read_text_file(config).value();
  ASSERT_TRUE(write_text_file(config, good + "\nnonsense = 1\n"));
  EXPECT_THAT(why(), HasSubstr("nonsense"));
  ASSERT_TRUE(write_text_file(config, good));
  fs::copy_file(folder / "desk/still.png", folder / "still.png");
  replace_in(config, "\"still.png\"", "\"../still.png\"");
  replace_in(config, "folder = \"" + (folder / "state").string() + "\"", "folder = \"memory\"");
  EXPECT_THAT(why(), testing::AllOf(HasSubstr("still.png: lies outside"), HasSubstr("[state] folder = \"memory\"")));
  EXPECT_FALSE(fs::exists(out));
  ASSERT_TRUE(write_text_file(config, good));
  // The GPU's: a lens that folds the picture (fault 31).
  replace_in(config, "distortion = [-0.6,", "distortion = [-300.0,");
  EXPECT_THAT(why(), HasSubstr("folds the picture"));
  EXPECT_FALSE(fs::exists(out));
}

// Damaged, or changed by somebody since: it is not what was signed.
TEST_F(Starting, Row46AGenerationThatIsNotAsItWasSignedIsNotShown) {
  proven("Spring", kMonday);
  const auto summer = proven("Summer", kMonday + 24h);
  EXPECT_EQ(caption(), "Summer");
  replace_in(folder / "content" / summer / "kasumi.toml", "\"Summer\"", "\"Hacked\"");
  const auto shown = start();
  EXPECT_EQ(shown->config.still.caption, "Spring");
  ASSERT_TRUE(shown->instead);
  EXPECT_THAT(shown->instead->refused.front(), HasSubstr("kasumi.toml"));
}

}  // namespace
}  // namespace kasumi
