// The probation of new content: by itself on a clock that the test turns, then in the whole appliance.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/appliance/proving_loop.hpp"
#include "pipeline/kiosk/content/probation.hpp"
#include "tests/pipeline/kiosk/content/kiosk_rig.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

const Probation::FailingChecks kWell{}, kNoSky{{"sky_camera.open", "not available"}};

// A kiosk whose spring is proven and whose summer is shown now.
struct OnProbation : testing::Test {
  OnProbation() : folder(content_folder("probation")), generations(folder / "content") {
    place = {write_desk(folder / "etc"), generations};
    const auto config = write_desk(folder / "desk");
    spring = install_file(packed(config, "Spring", kMonday), generations, kMonday)->generation.id;
    EXPECT_TRUE(generations.note_proven(spring, kMonday));
    summer = install_file(packed(config, "Summer", kMonday + 1h), generations, kMonday + 1h)->generation.id;
    probation = std::make_unique<Probation>(place, [this] { ++reloads; });
    show(summer);
  }
  void show(const std::string& id) {
    Content content;
    content.files.push_back({generations.config_of(*generations.find(id))});
    probation->adopt(content, now);
  }
  void pass(Duration by, bool pictures, const Probation::FailingChecks& failing = kWell) {
    for (Duration done{}; done < by; done += kStep) {
      now += std::chrono::duration_cast<Utc::duration>(kStep);
      probation->step(kStep, pictures, failing, now);
    }
  }
  std::string shown() const { return generations.current() ? generations.current()->manifest.name : "by hand"; }
  fs::path folder;
  Generations generations;
  ContentPlace place;
  std::string spring, summer;
  std::unique_ptr<Probation> probation;
  int reloads = 0;
  Utc now = kMonday + 2h;
};

TEST_F(OnProbation, TenMinutesOfPicturesAndAWellDoctorKeepIt) {
  EXPECT_EQ(probation->status().left, 10min);
  pass(9min + 50s, true);
  EXPECT_TRUE(generations.current()->on_probation());
  EXPECT_EQ(probation->status().left, 10s);
  pass(20s, true);
  EXPECT_TRUE(generations.current()->proven);
  pass(3h, false, kNoSky);
  EXPECT_EQ(shown(), "Summer") << "what happens later is not held against it";
  EXPECT_EQ(reloads, 0);
}

TEST_F(OnProbation, WithoutPicturesItGoesBackAfterHalfAnHour) {
  pass(4min, true);
  pass(25min, false);
  EXPECT_EQ(shown(), "Summer");
  pass(2min, false);
  EXPECT_EQ(shown(), "Spring");
  EXPECT_EQ(reloads, 1) << "and the screen is asked to show it";
  ASSERT_TRUE(probation->status().went_back || probation->status().shown->went_back);
  EXPECT_THAT(generations.find(summer)->went_back->why, HasSubstr("for 4 of 30 minutes"));
  show(spring);
  ASSERT_TRUE(probation->status().went_back);
  EXPECT_EQ(probation->status().went_back->id, summer);
  pass(2h, true);
  EXPECT_EQ(reloads, 1);
}

TEST_F(OnProbation, WhereTheDoctorFindsWhatWasWellBeforeItGoesBack) {
  pass(31min, true, kNoSky);
  EXPECT_EQ(shown(), "Spring");
  EXPECT_THAT(generations.find(summer)->went_back->why, HasSubstr("kasumi doctor: sky_camera.open: not available"));
}

TEST_F(OnProbation, WhatPassesIsNotHeldAgainstIt) {
  pass(20min, true, kNoSky);
  EXPECT_TRUE(generations.current()->on_probation());
  pass(kStep, true);
  EXPECT_TRUE(generations.current()->proven);
}

TEST_F(OnProbation, WhatFailedBeforeIsNotHeldAgainstItNorAfterARestart) {
  show(spring);
  pass(kStep, true, kNoSky);
  show(summer);
  EXPECT_THAT(generations.find(summer)->failed_before, testing::ElementsAre("sky_camera.open"));
  probation = std::make_unique<Probation>(place, [this] { ++reloads; });
  show(summer);
  pass(11min, true, kNoSky);
  EXPECT_TRUE(generations.current()->proven);
}

TEST_F(OnProbation, WithNothingReadableBeforeItItStays) {
  ASSERT_TRUE(generations.remove(spring));
  ASSERT_TRUE(write_text_file(place.config, "nonsense = 1\n"));
  pass(2h, false);
  EXPECT_EQ(shown(), "Summer");
  EXPECT_EQ(reloads, 0);
}

TEST_F(OnProbation, IfTheScreenDoesNotTakeTheOldContentItIsAskedAgain) {
  pass(31min, false);
  ASSERT_EQ(reloads, 1);
  pass(25min, false);
  EXPECT_EQ(reloads, 3);
}

// It is still on the screen, since the old content was refused, when somebody installs it once more.
TEST_F(OnProbation, TriedOnceMoreItHasHalfAnHourAgain) {
  pass(4min, true);
  pass(27min, false);
  ASSERT_EQ(shown(), "Spring");
  ASSERT_TRUE(generations.show(&summer));
  show(summer);
  pass(9min, true);
  EXPECT_EQ(shown(), "Summer");
  EXPECT_TRUE(generations.current()->on_probation()) << "the pictures of before do not count";
  pass(2min, true);
  EXPECT_TRUE(generations.current()->proven);
}

// A camera that gives a picture every 20 s, between the looks of the loop too.
TEST_F(OnProbation, ASlowCamerasPicturesCountUntilItStalls) {
  ManualClock clock(now);
  Mailboxes mailboxes;
  Content content;
  content.files.push_back({generations.config_of(*generations.find(summer))});
  ProvingLoop proving(std::make_shared<const Content>(std::move(content)), {}, {place, {}, [this] { ++reloads; }},
                      clock, mailboxes);
  std::uint64_t pictures = 0;
  const auto look = [&](Duration by, bool goes_on) {
    for (Duration done{}; done < by; done += kStep) {
      clock.advance(kStep);
      if (goes_on && done % 20s == Duration{}) ++pictures;
      mailboxes.proving.see(pictures, 20s, false);
      proving.step();
    }
  };
  look(5min, true);
  look(15min, false);
  look(4min, true);
  EXPECT_TRUE(generations.current()->on_probation()) << "what stands still proves nothing";
  look(1min, true);
  EXPECT_TRUE(generations.current()->proven);
}

TEST(Proving, Row22NewContentServesItsProbationUnderTheLivePicture) {
  KioskRig rig("probation");
  rig.start();
  rig.pass(20s);
  EXPECT_TRUE(rig.content()["generation"].is_null());
  rig.install("Spring", "The view returns in a moment.", "Spring");
  rig.hang_up();
  rig.pass(30s);
  auto now = rig.content();
  EXPECT_EQ(now["generation"]["name"], "Spring");
  EXPECT_TRUE(now["generation"]["proven_utc"].is_null());
  EXPECT_NEAR(now["generation"]["probation_left_s"].get<double>(), 575.0, 20.0);
  EXPECT_TRUE(now["generation"]["probation_until_utc"].is_string());
  rig.pass(10min, kStep);
  now = rig.content();
  EXPECT_TRUE(now["generation"]["proven_utc"].is_string()) << now.dump(1);
  EXPECT_TRUE(now["generation"]["probation_left_s"].is_null());
  EXPECT_TRUE(now["went_back"].is_null());
}

TEST(Proving, Row22ContentWithAnotherCameraThatIsNotThereIsGoneHalfAnHourLater) {
  KioskRig rig("probation-dark");
  rig.start();
  rig.pass(20s);
  // The scene camera's size is not the recording's: every frame is rejected, and nobody at the desk could know.
  rig.install("Wrong", "[scene.camera]\nsource = \"replay\"\n",
              "[scene.camera]\nsource = \"v4l2\"\ndevice = \"/dev/v4l/by-id/not-there\"\n#");
  rig.hang_up();
  rig.pass(60s);
  EXPECT_EQ(rig.shown(), Shown::still);
  EXPECT_EQ(rig.content()["generation"]["name"], "Wrong");
  rig.pass(31min, kStep);
  rig.pass(5s);
  EXPECT_EQ(rig.shown(), Shown::live) << "the old content, by itself";
  const auto now = rig.content();
  EXPECT_TRUE(now["generation"].is_null()) << now.dump(1);
  EXPECT_EQ(now["went_back"]["name"], "Wrong");
  EXPECT_THAT(now["went_back"]["why"].get<std::string>(), HasSubstr("for 0 of 30 minutes"));
}

// Sent in the evening, gone in the morning; and what is right is kept by then.
TEST(Proving, Row22AtNightTheCamerasPicturesHaveToDo) {
  KioskRig rig("probation-night", "\n[opening]\ntime_zone = \"UTC\"\nevery_day = \"closed\"\n");
  rig.start();
  rig.pass(20s);
  ASSERT_EQ(rig.shown(), Shown::dark);
  rig.install("Spring", "[state]", "[opening]\ntime_zone = \"UTC\"\nevery_day = \"closed\"\n[state]");
  rig.hang_up();
  rig.pass(11min, kStep);
  EXPECT_EQ(rig.shown(), Shown::dark);
  EXPECT_TRUE(rig.content()["generation"]["proven_utc"].is_string()) << rig.content().dump(1);
}

}  // namespace
}  // namespace kasumi
