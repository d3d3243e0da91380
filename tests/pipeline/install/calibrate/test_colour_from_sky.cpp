// The spectral sensitivity estimated from skies of the independent generator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/files.hpp"
#include "calib/colour/non_negative.hpp"
#include "estimator/sky_camera/sensitivity_error.hpp"
#include "estimator/sky_camera/sky_colours.hpp"
#include "estimator/sky_camera/sky_sensitivity.hpp"
#include "fixtures/landscape/fisheye_view.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

const std::filesystem::path kCameras = shared_data_folder() / "spectral" / "rawtoaces";

std::vector<SpectralSensitivity> measured_cameras() {
  std::vector<SpectralSensitivity> cameras;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(kCameras, error))
    cameras.push_back(read_spectral_sensitivity(entry.path()).value());
  std::sort(cameras.begin(), cameras.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return cameras;
}

// Bell curves: an invented camera, for machines without the measured ones.
SpectralSensitivity bells(const char* name, const glm::dvec3& peaks_nm, const glm::dvec3& widths_nm) {
  SpectralSensitivity camera{name, 380.0, 5.0, {}};
  for (double nm = 380.0; nm <= 780.0; nm += 5.0) {
    const glm::dvec3 off = (nm - peaks_nm) / widths_nm;
    camera.samples.push_back(glm::exp(-0.5 * off * off));
  }
  return camera;
}

std::vector<SpectralSensitivity> invented_cameras() {
  return {bells("a", {610, 535, 460}, {30, 38, 28}), bells("b", {595, 530, 470}, {42, 42, 33}),
          bells("c", {602, 545, 455}, {36, 35, 25}), bells("d", {590, 538, 465}, {45, 46, 30})};
}

struct Day {
  Camera camera;
  std::vector<SunMoment> moments;
};

// A day of constant air: 8-bit fisheye pictures of this sensitivity, with noise, at three sun positions.
Day day_of(const SpectralSensitivity& sensitivity, double turbidity) {
  fixtures::FisheyeSpec options;
  options.size = 180;
  Day day{fixtures::sky_camera(options).camera, {}};
  day.camera.sensitivity = sensitivity;
  day.camera.white_balance = fixtures::daylight_white_balance(sensitivity);
  for (const double sun_zenith_deg : {40.0, 58.0, 75.0}) {
    fixtures::Weather weather;
    weather.turbidity = turbidity;
    weather.sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(160.0));
    fixtures::FisheyeScenery view_options;
    view_options.obstructions = false;
    const auto view = fixtures::look_at_sky(fixtures::Illumination(weather), day.camera, view_options);
    auto exposure = fixtures::automatic_exposure(view.light, 0.92, 0.72);
    exposure.noise = true;
    exposure.seed = 5 + static_cast<std::uint64_t>(day.moments.size());
    const auto pixels = fixtures::expose(view.light, day.camera, exposure);
    day.moments.push_back(
        {fmt::format("sun at {} deg", sun_zenith_deg), sky_picture(view_of(pixels), day.camera).value(), weather.sun});
  }
  return day;
}

// The colours of such a day.
std::vector<DaylightColour> colours_of(const SpectralSensitivity& sensitivity, double turbidity,
                                       double believed_turbidity) {
  const auto day = day_of(sensitivity, turbidity);
  std::vector<DaylightColour> colours;
  int number = 0;
  for (const auto& moment : day.moments) {
    const auto look = SkyObserver(day.camera).observe(moment.picture, moment.sun);
    const auto more = sky_colours(moment.picture, look, day.camera, Turbidity{believed_turbidity}, number++);
    colours.insert(colours.end(), more.begin(), more.end());
  }
  return colours;
}

std::vector<SpectralSensitivity> without(const std::vector<SpectralSensitivity>& cameras, std::size_t out) {
  std::vector<SpectralSensitivity> others;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (i != out) others.push_back(cameras[i]);
  return others;
}

// Gain times area: each channel's response to an equal-energy spectrum, relative to green; independent of how curves
// are scaled.
glm::dvec2 balance_of(const SpectralSensitivity& sensitivity, const glm::dvec3& gains) {
  glm::dvec3 area{0.0};
  for (double nm = 380.0; nm <= 780.0; nm += 1.0) area += gains * daylight_components(nm).x * sensitivity.at(nm);
  return {area.r / area.g, area.b / area.g};
}

TEST(ColourFromSky, EachMeasuredCameraIsFoundFromTheOthersAndTheSkyWithinAHundredthOfGamma) {
  const auto cameras = measured_cameras();
  if (cameras.size() < 4) GTEST_SKIP() << kCameras << ": the measured cameras are not there";
  constexpr double kTurbidity = 3.0;
  std::printf("%-34s %6s | largest error of Gamma at T = 2 3 4 5 6 7 8, s <= 10 km\n", "camera", "T off");
  for (const double off : {0.0, 0.1})
    for (std::size_t out = 0; out < cameras.size(); ++out) {
      const auto colours = colours_of(cameras[out], kTurbidity, kTurbidity + off);
      const auto fit = must(fit_sensitivity(colours, without(cameras, out)));
      const auto error = gamma_error(fit->sensitivity, cameras[out]);
      std::printf("%-34s %6.1f |", cameras[out].name.c_str(), off);
      for (const double one : error.by_turbidity) std::printf(" %.4f", one);
      const auto chosen = without(cameras, out);
      const auto nearest = std::min_element(chosen.begin(), chosen.end(), [&](const auto& a, const auto& b) {
        return explain(colours, a).rms < explain(colours, b).rms;
      });
      std::printf(" | %.4f; chosen from the files %.4f\n", error.largest, gamma_error(*nearest, cameras[out]).largest);
      EXPECT_LE(error.largest, 0.01) << cameras[out].name;
      const auto truth = balance_of(cameras[out], fixtures::daylight_white_balance(cameras[out]));
      const auto found = balance_of(fit->sensitivity, fit->residuals.white_balance);
      EXPECT_NEAR(found.x / truth.x, 1.0, off > 0.0 ? 0.05 : 0.02);
      EXPECT_NEAR(found.y / truth.y, 1.0, off > 0.0 ? 0.05 : 0.02);
    }
}

TEST(ColourFromSky, ACameraAmongTheFilesExplainsTheSkyBest) {
  const auto cameras = invented_cameras();
  const auto colours = colours_of(cameras[1], 3.0, 3.0);
  const auto right = explain(colours, cameras[1]);
  for (const std::size_t other : {0u, 2u, 3u}) EXPECT_GT(explain(colours, cameras[other]).rms, 1.2 * right.rms);
  const auto truth = fixtures::daylight_white_balance(cameras[1]);
  EXPECT_NEAR(right.white_balance.r, truth.r / truth.g, 0.005);
  EXPECT_NEAR(right.white_balance.b, truth.b / truth.g, 0.005);
}

TEST(ColourFromSky, AnInventedCameraIsFoundAndItsReportedUncertaintyHolds) {
  const auto cameras = invented_cameras();
  for (const std::size_t out : {0u, 3u}) {
    const auto others = without(cameras, out);
    const auto colours = colours_of(cameras[out], 3.0, 3.0);
    const auto fit = fit_sensitivity(colours, others).value();
    EXPECT_LE(gamma_error(fit.sensitivity, cameras[out]).largest, 0.01);
    EXPECT_GE(fit.determined, 4);
    const glm::dvec3 peaks = out == 0 ? glm::dvec3{610, 535, 460} : glm::dvec3{590, 538, 465};
    for (int c = 0; c < 3; ++c) {
      const auto& place = fit.places[static_cast<std::size_t>(c)];
      EXPECT_NEAR(place.mean_nm, peaks[c], 4.0 * place.sigma_nm + 1.0);
      EXPECT_LT(place.sigma_nm, place.before_sigma_nm);
    }
    for (const auto& sample : fit.sensitivity.samples)
      for (int c = 0; c < 3; ++c) EXPECT_GE(sample[c], 0.0);
    // The error leave_one_out predicts, from the sky and the other cameras alone, has the size of the actual one.
    const auto expected = leave_one_out(colours, fit.residuals.left, others);
    ASSERT_EQ(expected.size(), others.size());
    for (const auto& error : expected) EXPECT_LE(error.largest, 0.02);
  }
}

TEST(SensitivityFromSky, TheMeasuredCameraThatTookTheSkyIsChosen) {
  const auto cameras = invented_cameras();
  const auto day = day_of(cameras[1], 3.0);
  const auto found = must(sensitivity_from_sky(day.camera, day.moments, cameras, {.choose = true}));
  EXPECT_EQ(found->sensitivity.name, cameras[1].name);
  ASSERT_EQ(found->ranked.size(), cameras.size());
  EXPECT_EQ(found->ranked.front().camera, 1u);
  EXPECT_EQ(found->residuals.rms, found->ranked.front().residuals.rms);
  ASSERT_EQ(found->turbidities.size(), day.moments.size());
  for (const double turbidity : found->turbidities) EXPECT_NEAR(turbidity, 3.0, 0.2);
  const auto truth = fixtures::daylight_white_balance(cameras[1]);
  EXPECT_NEAR(found->residuals.white_balance.r, truth.r / truth.g, 0.02);
  EXPECT_NEAR(found->residuals.white_balance.b, truth.b / truth.g, 0.02);
  EXPECT_FALSE(found->of_more_colourful_sky) << "only a fit follows it";
}

TEST(SensitivityFromSky, AnUnmeasuredCameraIsFittedFromTheOthers) {
  const auto cameras = invented_cameras();
  const auto day = day_of(cameras[0], 3.0);
  const auto others = without(cameras, 0);
  const auto found = must(sensitivity_from_sky(day.camera, day.moments, others, {.turbidity = 3.0}));
  ASSERT_TRUE(found->fit);
  EXPECT_LE(gamma_error(found->sensitivity, cameras[0]).largest, 0.01);
  EXPECT_THAT(found->turbidities, testing::Each(3.0));
  EXPECT_EQ(found->expected.size(), others.size());
  EXPECT_GT(found->of_more_colourful_sky.value_or(0.0), 0.0);
}

TEST(SensitivityFromSky, WithoutAClearSkyTheReasonIsGivenForEachPicture) {
  const auto cameras = invented_cameras();
  auto day = day_of(cameras[1], 3.0);
  for (auto& moment : day.moments)
    for (auto& pixel : moment.picture.encoded.elements()) pixel = glm::vec3(0.5F);
  const auto found = sensitivity_from_sky(day.camera, day.moments, cameras);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, FaultKind::bad_input);
  EXPECT_THAT(found.error().message,
              testing::AllOf(testing::HasSubstr("no picture shows a clear enough sky"),
                             testing::HasSubstr("\nsun at 40 deg: "), testing::HasSubstr("\nsun at 75 deg: ")));
}

TEST(ColourFromSky, TheWrittenFileIsReadBackUnchanged) {
  const auto camera = invented_cameras()[2];
  const auto path = test_output_folder() / "sensitivity.csv";
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_text_file(path, csv_of(camera, "two\nlines")));
  const auto again = read_spectral_sensitivity(path).value();
  for (const double nm : {400.0, 455.0, 512.0, 600.0, 701.0})
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(again.at(nm)[c], camera.at(nm)[c], 1e-5);
}

TEST(ColourFromSky, AllMissingInputsAreReportedAtOnce) {
  const auto fault = fit_sensitivity({}, std::vector{generic_sensitivity()}).error();
  EXPECT_EQ(fault.kind, FaultKind::bad_input);
  EXPECT_THAT(fault.message, testing::AllOf(testing::HasSubstr("1 measured cameras: expected at least 2"),
                                            testing::HasSubstr("0 parts of a clear sky: expected at least 8")));
}

// For a positive definite matrix, the Karush-Kuhn-Tucker conditions hold at the optimum and nowhere else.
TEST(NonNegative, TheMinimumHasNoDescentDirection) {
  std::mt19937_64 random(7);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  for (int round = 0; round < 20; ++round) {
    constexpr int kSize = 40, kBounded = 37;
    Eigen::MatrixXd root(kSize, kSize);
    Eigen::VectorXd pull(kSize);
    for (int i = 0; i < kSize; ++i) {
      pull[i] = uniform();
      for (int j = 0; j < kSize; ++j) root(i, j) = uniform();
    }
    const Eigen::MatrixXd matrix = root * root.transpose() + 0.01 * Eigen::MatrixXd::Identity(kSize, kSize);
    const auto solved = least_non_negative(matrix, pull, kBounded);
    const Eigen::VectorXd slope = matrix * solved.x - pull;
    int held = 0;
    for (int i = 0; i < kSize; ++i) {
      EXPECT_GE(i < kBounded ? solved.x[i] : 0.0, 0.0);
      if (i < kBounded && solved.x[i] == 0.0) {
        EXPECT_GE(slope[i], -1e-9);
        ++held;
      } else {
        EXPECT_NEAR(slope[i], 0.0, 1e-9);
      }
    }
    EXPECT_GT(held, 3);
  }
}

}  // namespace
}  // namespace kasumi
