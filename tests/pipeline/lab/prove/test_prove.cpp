// `kasumi prove` on pictures of known air, as a person calls it.
#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/lab/prove/proof_json.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/lab/prove/drawn_series.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const DrawnSeries& series() {
  static const auto drawn = draw_series(test_folder("prove"));
  return drawn;
}

ProveRequest asked() {
  ProveRequest request;
  request.scenes = {"@" + series().list.string()};
  request.part = "abbey";
  request.landmarks = series().landmarks.string();
  request.faces_deg = 0.0;
  request.lat = 45.5;
  request.lon = 9.2;
  return request;
}

TEST(Prove, UnderTheTrueAirTheBuildingIsDrawnAsItIsSeen) {
  auto request = asked();
  request.air = series().air.string();
  const auto proof = must(prove(request));
  const auto summary = summary_of(*proof);
  EXPECT_EQ(summary.ways[0].pictures, 39U);
  EXPECT_LE(summary.ways[0].median_255, 0.5);
  EXPECT_LE(summary.ways[0].p95_255, 1.5);
  EXPECT_LE(summary.pixel_median_255, 2.5) << "registered to a part of a pixel";
  EXPECT_GE(summary.ways[1].p95_255, 40.0) << "without air";
  EXPECT_GT(summary.ways[3].p95_255, 10.0) << "no constant air suits all days";
  EXPECT_NEAR(proof->shade.g, 0.08, 0.01);
}

TEST(Prove, TheOtherTowersTellTheAir) {
  const auto proof = must(prove(asked()));
  const auto summary = summary_of(*proof);
  EXPECT_EQ(proof->scene.others.size(), 6U);
  EXPECT_THAT(proof->scene.left_aside, testing::ElementsAre("abbey"));
  EXPECT_LE(summary.ways[0].median_255, 3.0);
  EXPECT_LE(summary.ways[0].p95_255, 8.0);
  EXPECT_GE(summary.within_sigma_share, 0.6);
}

TEST(Prove, LeavesOutWhatSaysNothingWithTheReasonAndFollowsAViewThatJumps) {
  auto request = asked();
  request.air = series().air.string();
  const auto proof = must(prove(request));
  ASSERT_EQ(proof->pictures.size(), series().pictures.size());
  for (const auto& picture : proof->pictures) {
    const auto& view = proof->scene.views[picture.view];
    const auto drawn = std::ranges::find(series().pictures, view.file.stem().string(), &DrawnPicture::name);
    if (drawn->night) {
      EXPECT_THAT(picture.left_out, HasSubstr("night"));
      continue;
    }
    if (drawn->drops) {
      EXPECT_THAT(picture.left_out, HasSubstr("drops on the lens"));
    } else {
      EXPECT_EQ(picture.left_out, "") << drawn->name;
    }
    EXPECT_NEAR(view.moved_px, drawn->moved_px, 0.3) << drawn->name;
  }
}

TEST(Prove, WritesAPageASheetAndNumbers) {
  const char* kept = std::getenv("KASUMI_PROOF");  // docs/make-pictures
  const auto out = kept ? std::filesystem::path(kept) : test_folder("proof");
  const auto said =
      ended(0, run_kasumi(fmt::format("prove @{} --part abbey --landmarks {} --out {}", series().list.string(),
                                      series().landmarks.string(), out.string())));
  EXPECT_THAT(said.out, HasSubstr("abbey at 3.00 km"));
  const auto page = read_text_file(out / "index.html").value();
  EXPECT_THAT(page, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(page, testing::Not(HasSubstr("<script")));
  EXPECT_TRUE(std::filesystem::exists(out / "sheet.png"));
  const auto json = parse_json(read_text_file(out / "proof.json").value());
  EXPECT_EQ(json["part"], "abbey");
  EXPECT_LT(json["errors"]["told"]["error_median_255"], json["errors"]["no_air"]["error_median_255"]);
  EXPECT_EQ(json["pictures"].size(), series().pictures.size());
  EXPECT_TRUE(json["classes"].contains("haze"));
}

TEST(Prove, TheDoctorTellsOfItsResult) {
  const auto state = test_folder("proved-state");
  std::filesystem::create_directories(state);
  Findings none;
  std::filesystem::remove(state / "proof.json");
  check_proof(state, Utc{}, none);
  EXPECT_TRUE(none.all().empty());
  ended(0, run_kasumi(fmt::format("prove @{} --part abbey --landmarks {} --air {} --out {} --state {}",
                                  series().list.string(), series().landmarks.string(), series().air.string(),
                                  test_folder("proof-kept").string(), state.string())));
  Findings findings;
  check_proof(state, SystemClock().utc(), findings);
  ASSERT_EQ(findings.all().size(), 1U);
  EXPECT_EQ(findings.all()[0].grade, Grade::good);
  EXPECT_THAT(findings.all()[0].found, HasSubstr("0 days ago abbey was drawn 0."));
  ASSERT_TRUE(write_text_file(state / "proof.json", "{}"));
  check_proof(state, SystemClock().utc(), findings);
  EXPECT_EQ(findings.worst(), Grade::warning);
}

TEST(Prove, SaysAllThatIsWrong) {
  const auto said =
      ended(2, run_kasumi(fmt::format("prove @{} --part tower --landmarks {} --out {}", series().list.string(),
                                      series().landmarks.string(), test_folder("none").string())));
  EXPECT_THAT(said.err, HasSubstr("expected a landmark of --landmarks (mill, church"));
  EXPECT_THAT(said.err, HasSubstr("--distance-m"));
}

}  // namespace
}  // namespace kasumi
