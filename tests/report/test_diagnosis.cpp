// What visitors see and what is wrong, in every language.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "base/words/texts.hpp"
#include "report/diagnosis/symptom_words.hpp"
#include "report/show.hpp"
#include "tests/report/told.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr;

std::vector<Ill> ills_of(const std::string& status) {
  std::vector<Ill> ills;
  for (const auto& symptom : diagnose(heard_of(status)).symptoms) ills.push_back(symptom.ill);
  return ills;
}

TEST(Diagnoses, AKioskInGoodHealthHasNone) {
  const auto diagnosis = diagnose(heard_of(kGoodStatus));
  EXPECT_EQ(diagnosis.sight, Sight::live);
  EXPECT_THAT(diagnosis.symptoms, testing::IsEmpty());
}

TEST(Diagnoses, EachSymptomIsFoundInWhatIsTold) {
  const auto still = [](Trouble trouble) {
    return changed(kGoodStatus, "\"live\", \"reason\": \"\"",
                   fmt::format("\"still\", \"reason\": \"{}\"", name_of(trouble)));
  };
  using testing::ElementsAre;
  EXPECT_THAT(ills_of(still(Trouble::starting)), ElementsAre(Ill::starting));
  EXPECT_THAT(ills_of(still(Trouble::scene_lost)), ElementsAre(Ill::scene_lost));
  EXPECT_THAT(ills_of(still(Trouble::scene_frozen)), ElementsAre(Ill::scene_frozen));
  EXPECT_THAT(ills_of(still(Trouble::scene_covered)), ElementsAre(Ill::scene_covered));
  EXPECT_THAT(ills_of(still(Trouble::scene_white_out)), ElementsAre(Ill::scene_white_out));
  EXPECT_THAT(ills_of(still(Trouble::no_display)), ElementsAre(Ill::no_display));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"safe_mode\": false", "\"safe_mode\": true")),
              ElementsAre(Ill::safe_mode));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"draw_refused\": null", "\"draw_refused\": \"mask\"")),
              ElementsAre(Ill::cannot_draw));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"sky_camera\": {\"up\": true", "\"sky_camera\": {\"up\": false")),
              ElementsAre(Ill::sky_lost));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"clock_trusted\": true", "\"clock_trusted\": false")),
              ElementsAre(Ill::clock_unset));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"supposed\": false", "\"supposed\": true")),
              ElementsAre(Ill::air_supposed));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"finding\": false", "\"finding\": true")),
              ElementsAre(Ill::observers_disagree));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"steady\"", "\"drifted\"")), ElementsAre(Ill::camera_soiled));
  EXPECT_THAT(ills_of(changed(changed(kGoodStatus, "\"steady\"", "\"drifted\""), "\"dome\"", "\"view\"")),
              ElementsAre(Ill::camera_moved));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"pictures_share\": 1.0", "\"pictures_share\": 0.5")),
              ElementsAre(Ill::hot));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "{\"up\": true, \"silent_s\": 0.1}", "{\"up\": false, \"silent_s\": 9}")),
              ElementsAre(Ill::hung));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"refused\": []", "\"refused\": [\"x\"]")),
              ElementsAre(Ill::content_refused));
  EXPECT_THAT(ills_of(changed(kGoodStatus, "\"problems\": []", "\"problems\": [\"x\"]")),
              ElementsAre(Ill::reload_refused));
}

TEST(Diagnoses, WhatHidesThePictureComesFirst) {
  const auto status = changed(changed(kGoodStatus, "\"clock_trusted\": true", "\"clock_trusted\": false"),
                              "\"scene_camera\": {\"up\": true, \"cause\": \"\"",
                              "\"scene_camera\": {\"up\": false, \"cause\": \"unplugged\"");
  const auto symptoms = diagnose(heard_of(status)).symptoms;
  ASSERT_EQ(symptoms.size(), 2U);
  EXPECT_EQ(symptoms[0].ill, Ill::scene_lost);
  EXPECT_EQ(symptoms[0].detail, "unplugged");
}

// What a symptom explains is not told beside it: there is one thing to do.
TEST(Diagnoses, OneCauseIsToldOnce) {
  using testing::ElementsAre;
  const auto still = [](Trouble trouble, const std::string& status = kGoodStatus) {
    return changed(status, "\"live\", \"reason\": \"\"",
                   fmt::format("\"still\", \"reason\": \"{}\"", name_of(trouble)));
  };
  const auto no_clock = changed(kGoodStatus, "\"clock_trusted\": true", "\"clock_trusted\": false");
  EXPECT_THAT(ills_of(changed(no_clock, "\"supposed\": false", "\"supposed\": true")), ElementsAre(Ill::clock_unset))
      << "no clear sky would help";
  EXPECT_THAT(ills_of(changed(no_clock, "\"finding\": false", "\"finding\": true")), ElementsAre(Ill::clock_unset));
  const auto refused = changed(kGoodStatus, "\"draw_refused\": null", "\"draw_refused\": \"mask\"");
  EXPECT_THAT(ills_of(still(Trouble::starting, refused)), ElementsAre(Ill::cannot_draw)) << "pictures have come";

  const auto hung = changed(changed(kLostStatus, "\"cause\": \"unplugged\"", "\"cause\": \"hung\""),
                            "{\"up\": true, \"silent_s\": 0.1}", "{\"up\": false, \"silent_s\": 9}");
  EXPECT_THAT(ills_of(hung), ElementsAre(Ill::scene_lost));
  EXPECT_THAT(ills_of(changed(hung, "\"loops\": {", "\"loops\": {\"state\": {\"up\": false, \"silent_s\": 9}, ")),
              ElementsAre(Ill::scene_lost, Ill::hung))
      << "the disk is another matter";
}

TEST(Diagnoses, PicturesOfAnotherSizeAreNoMatterOfACable) {
  const auto status = changed(kLostStatus, "unplugged", "1280x720 instead of 960x540");
  const auto symptoms = diagnose(heard_of(status)).symptoms;
  ASSERT_EQ(symptoms.size(), 1U);
  EXPECT_EQ(symptoms[0].ill, Ill::cannot_draw);
  EXPECT_EQ(symptoms[0].detail, "1280x720 instead of 960x540");
  EXPECT_THAT(std::string(symptom_words(Ill::cannot_draw, Language::english).what_to_do), HasSubstr("picture size"));
}

TEST(Diagnoses, ContentThatAReloadRefusesAgainIsToldOnceAndAsItIsNow) {
  const auto status = changed(changed(kGoodStatus, "\"refused\": []", "\"refused\": [\"as it was\", \"more\"]"),
                              "\"problems\": []", "\"problems\": [\"as it is\"]");
  const auto symptoms = diagnose(heard_of(status)).symptoms;
  ASSERT_EQ(symptoms.size(), 1U);
  EXPECT_EQ(symptoms[0].ill, Ill::content_refused);
  EXPECT_EQ(detail_text(symptoms[0], *parse_language("ja")), "as it is");
}

// The status lists the first fifty and counts the rest; of those we read sixteen.
TEST(Diagnoses, AllProblemsAreCountedHoweverManyThereAre) {
  const auto more = [](std::size_t lines, const std::string& last) {
    std::string list;
    for (std::size_t i = 0; i < lines; ++i) list += fmt::format("\"problem {}\", ", i);
    const auto status = changed(kGoodStatus, "\"problems\": []", fmt::format("\"problems\": [{}\"{}\"]", list, last));
    return diagnose(heard_of(status)).symptoms.at(0).more;
  };
  EXPECT_EQ(more(3, "the last"), 3U);
  EXPECT_EQ(more(29, "the last"), 29U);
  EXPECT_EQ(more(50, "and 59950 more"), 59999U);
  EXPECT_EQ(more(50, "and 12 more files"), 50U) << "which is a problem";
}

// Nothing has ever worked here: then no earlier content is shown.
TEST(Diagnoses, RefusedContentIsNotSaidToBeReplacedByContentThatIsNone) {
  const auto status = changed(changed(kGoodStatus, "\"live\", \"reason\": \"\"",
                                      fmt::format("\"still\", \"reason\": \"{}\"", name_of(Trouble::content_refused))),
                              "\"refused\": []", "\"refused\": [\"x: unknown key\"]");
  const auto text = state_text(heard_of(status), Language::english);
  EXPECT_THAT(text, HasSubstr("shown is what worked last, else the still picture."));
  EXPECT_THAT(text, HasSubstr("x: unknown key\n"));
}

TEST(Diagnoses, ClosedIsNoFault) {
  const auto status = changed(changed(kGoodStatus, "\"live\", \"reason\": \"\"", "\"dark\", \"reason\": \"closed\""),
                              "\"display\": {\"up\": true", "\"display\": {\"up\": false");
  const auto diagnosis = diagnose(heard_of(status));
  EXPECT_EQ(diagnosis.sight, Sight::closed);
  EXPECT_TRUE(is_well(diagnosis.sight));
  EXPECT_THAT(diagnosis.symptoms, testing::IsEmpty());
}

TEST(Diagnoses, AbsenceAndSilenceAreFaultsOfTheirOwn) {
  for (const auto& [contact, ill] : {std::pair{Contact::absent, Ill::not_running},
                                     {Contact::silent, Ill::silent},
                                     {Contact::unreadable, Ill::unreadable}}) {
    const auto diagnosis = diagnose({contact, std::nullopt, "why", {}});
    EXPECT_EQ(diagnosis.sight, Sight::unknown);
    ASSERT_EQ(diagnosis.symptoms.size(), 1U);
    EXPECT_EQ(diagnosis.symptoms[0].ill, ill);
    EXPECT_FALSE(is_well(diagnosis.sight));
  }
}

TEST(Diagnoses, AreWordedInEveryLanguageAndNoTwoAlike) {
  const auto entries = [](std::string_view section) {
    return std::ranges::count_if(text_keys(), [&](std::string_view key) { return key.starts_with(section); });
  };
  EXPECT_EQ(entries("sight."), std::ssize(kAllSights)) << "every entry is used";
  EXPECT_EQ(entries("symptom."), 2 * std::ssize(kAllIlls)) << "every entry is used";
  for (const Language language : all_languages()) {
    std::set<std::string_view> said;
    for (const Ill ill : kAllIlls) {
      const auto words = symptom_words(ill, language);
      EXPECT_TRUE(said.insert(words.what).second) << words.what;
      EXPECT_FALSE(words.what.empty() || words.what_to_do.empty()) << name_of(ill) << code_of(language);
      EXPECT_FALSE(command_for(ill).empty());
      const bool is_english = words.what == symptom_words(ill, Language::english).what;
      EXPECT_EQ(is_english, language == Language::english) << words.what;
    }
    for (const Sight sight : kAllSights) EXPECT_TRUE(said.insert(sight_text(sight, language)).second);
  }
}

TEST(Diagnoses, ThePersonAtATerminalReadsWhatToDo) {
  const auto text = state_text({Contact::absent, std::nullopt, {}, {}}, *parse_language("de"));
  EXPECT_THAT(text, HasSubstr("Das Programm der Station läuft nicht."));
  EXPECT_THAT(text, HasSubstr("systemctl status kasumi"));
}

}  // namespace
}  // namespace kasumi::report
