#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calib/colour/colorimetry.hpp"
#include "estimator/air/attenuation.hpp"
#include "tests/estimator/air/every_camera.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

// On a grid that shares only its corners with the one to which the nodes were fitted.
double worst_error(const SpectralMeasure& measure, ScatteringModel model) {
  const AttenuationNodes nodes = attenuation_nodes(measure);
  double worst = 0.0;
  for (const double t : {1.7, 1.85, 2.0, 2.3, 2.7, 3.1, 3.7, 4.5, 5.5, 7.0, 9.0, 12.0, 15.0, 20.0}) {
    const HazeCoefficients haze = haze_coefficients(nodes, model, Turbidity{t});
    for (int i = 0; i <= 40; ++i) {
      const double s = i == 0 ? 0.0 : 10.0 * std::pow(5000.0, (i - 1) / 39.0);  // 0, 10 m .. 50 km
      const OpticalPath path{s, s};
      const glm::dvec3 error = attenuation(haze, path) - attenuation_reference(measure, model, Turbidity{t}, path);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(error[c]));
    }
  }
  return worst;
}

TEST(Attenuation, ReferenceOfASingleWavelengthIsBeersLaw) {
  SpectralMeasure line;
  line.weight.assign(401, glm::dvec3{0.0});
  line.weight[170] = glm::dvec3{1.0};  // 550 nm
  const OpticalPath path{3500.0, 3000.0};
  const double depth = .0141e-3 * 3500.0 + .063845e-3 / .6 * 2.0 * 3000.0;  // T = 3
  const glm::dvec3 gamma = attenuation_reference(line, ScatteringModel::morales2017, Turbidity{3.0}, path);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(gamma[c], std::exp(-depth), 1e-5);
}

TEST(Attenuation, TwoNodesPerChannelKeepWithin3em4ForEveryCamera) {
  for (const auto& camera : every_camera()) {
    const double worst = worst_error(spectral_measure(camera), ScatteringModel::morales2017);
    fmt::print("{:40} q_c          worst error {:.1e}\n", camera.name, worst);
    figure_row("attenuation", {camera.name, fmt::format("{:.1e}", worst)});
    EXPECT_LE(worst, 3e-4) << camera.name;
  }
}

TEST(Attenuation, TwoNodesPerChannelKeepWithinASixthOf8BitForCamerasThatDeliverSrgb) {
  for (const auto& sensitivity : every_camera()) {
    Camera camera;
    camera.sensitivity = sensitivity;
    camera.colour_space = Camera::ColourSpace::srgb;
    const double worst = worst_error(spectral_measure(camera), ScatteringModel::morales2017);
    fmt::print("{:40} q_c in sRGB  worst error {:.1e}\n", sensitivity.name, worst);
    EXPECT_LE(worst, 7e-4) << sensitivity.name;
  }
}

TEST(Attenuation, NodesServeTheOtherScatteringModelsToo) {
  const SpectralMeasure measure = spectral_measure(generic_sensitivity());
  EXPECT_LE(worst_error(measure, ScatteringModel::zhao), 5e-4);
  EXPECT_LE(worst_error(measure, ScatteringModel::preetham), 2e-3);  // K(lambda) bends, and is 73 times ours
}

TEST(Attenuation, NodesWeighOneTogetherSoThatNoDistanceAttenuatesNothing) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  const auto haze = haze_coefficients(nodes, ScatteringModel::morales2017, Turbidity{4.0});
  const glm::dvec3 gamma = attenuation(haze, {0.0, 0.0});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(gamma[c], 1.0, 1e-12);
}

TEST(Attenuation, SameMeasureGivesTheSameNodesBitForBit) {
  const auto measure = spectral_measure(generic_sensitivity());
  const auto first = attenuation_nodes(measure), second = attenuation_nodes(measure);
  for (std::size_t k = 0; k < kAttenuationNodes; ++k) {
    EXPECT_EQ(first.weight[k], second.weight[k]);
    EXPECT_EQ(first.wavelength_nm[k], second.wavelength_nm[k]);
  }
}

// A grey object under D65-like air: attenuated nanometre by nanometre and then seen by the camera, against the channel
// by channel equation. The difference is the error of M Eq 10.
double composite_error(const Camera& camera, const SpectralMeasure& measure, double grey) {
  const glm::dmat3 to_srgb = glm::inverse(srgb_to_xyz()) * camera_to_xyz(camera.sensitivity);
  const auto channels = [&](auto&& spectrum) {
    glm::dvec3 sum{0.0};
    for (int nm = 380; nm <= 780; ++nm) sum += spectrum(static_cast<double>(nm)) * camera.sensitivity.at(nm);
    return camera.colour_space == Camera::ColourSpace::srgb ? to_srgb * sum : sum;
  };
  const auto object = [&](double nm) { return grey * daylight_spectrum(.3320, .3474, nm); };  // D55
  const auto air = [](double nm) { return 0.5 * daylight_spectrum(.3127, .3290, nm); };       // D65
  const glm::dvec3 near = channels(object), far = channels(air);
  const double white = std::max({far.x, far.y, far.z, near.x, near.y, near.z});
  double worst = 0.0;
  for (const double t : {2.0, 3.0, 5.0, 8.0}) {
    for (const double s : {1000.0, 3500.0, 10e3, 30e3}) {
      const glm::dvec3 truth = channels([&](double nm) {
        const double gamma = std::exp(-s * (rayleigh_per_m(ScatteringModel::morales2017, nm) +
                                            mie_per_m(ScatteringModel::morales2017, nm, Turbidity{t})));
        return object(nm) * gamma + air(nm) * (1.0 - gamma);
      });
      const glm::dvec3 gamma = attenuation_reference(measure, ScatteringModel::morales2017, Turbidity{t}, {s, s});
      const glm::dvec3 error = Response::srgb().to_encoded(truth / white) -
                               Response::srgb().to_encoded((near * gamma + far * (1.0 - gamma)) / white);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, 255.0 * std::abs(error[c]));
    }
  }
  return worst;
}

// Weighted by the daylight of a chromaticity, because what is attenuated is light times sensitivity. Kasumi does not do
// this: it gains .1 of 255 on dark surfaces and loses as much on white ones.
SpectralMeasure weighted_by_daylight(SpectralMeasure measure, double x, double y) {
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < measure.weight.size(); ++i)
    sum += measure.weight[i] *= daylight_spectrum(x, y, measure.first_nm + static_cast<double>(i));
  for (auto& weight : measure.weight) weight /= sum;
  return measure;
}

TEST(Attenuation, ACameraThatDeliversSrgbIsAttenuatedByItsMixedSensitivity) {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  for (const double grey : {0.05, 0.3, 0.8}) {
    const double mixed = composite_error(camera, spectral_measure(camera), grey);
    const double plain = composite_error(camera, spectral_measure(camera.sensitivity), grey);
    const double weighted = composite_error(camera, weighted_by_daylight(spectral_measure(camera), .3127, .3290), grey);
    fmt::print("grey {:.2f}: worst composite error of 255: q_c {:.2f}, mixed {:.2f}, mixed x D65 {:.2f}\n", grey, plain,
               mixed, weighted);
    EXPECT_LE(mixed, 2.0);
    EXPECT_LE(weighted, 2.0);
  }
}

TEST(Attenuation, ASensorsChannelsAreAttenuatedByTheirOwnSensitivity) {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::sensor;
  for (const double grey : {0.05, 0.3, 0.8}) EXPECT_LE(composite_error(camera, spectral_measure(camera), grey), 1.5);
}

// Density along the path by a fine midpoint sum.
double brute_force(double from_m, double to_m, double distance_m, double scale_height_m) {
  constexpr int kSteps = 200000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += std::exp(-std::lerp(from_m, to_m, (i + 0.5) / kSteps) / scale_height_m);
  return sum * distance_m / kSteps;
}

TEST(OpticalPath, IsTheDensityIntegralOfASlantedPath) {
  for (const auto& [from, to, distance] : {std::array{100.0, 1500.0, 4000.0}, std::array{1500.0, 100.0, 4000.0},
                                           std::array{0.0, 12000.0, 30000.0}, std::array{300.0, 300.5, 3500.0}}) {
    const OpticalPath path = optical_path(from, to, distance);
    EXPECT_NEAR(path.rayleigh_m / brute_force(from, to, distance, kRayleighScaleHeight_m), 1.0, 1e-8);
    EXPECT_NEAR(path.mie_m / brute_force(from, to, distance, kMieScaleHeight_m), 1.0, 1e-8);
  }
}

TEST(OpticalPath, TendsToTheLevelPathWithoutCancellation) {
  const double level = optical_path(500.0, 500.0, 3500.0).mie_m;
  EXPECT_NEAR(level, 3500.0 * std::exp(-500.0 / 1200.0), 1e-9);
  for (const double rise : {1e-3, 1e-6, 1e-9, 1e-12, -1e-12, -1e-9, -1e-6, -1e-3}) {
    const double first_order = level * (1.0 - rise / (2.0 * 1200.0));
    EXPECT_NEAR(optical_path(500.0, 500.0 + rise, 3500.0).mie_m, first_order, 1e-8) << rise;  // metres
  }
}

TEST(OpticalPath, IsTheSameSeenFromEitherEnd) {
  EXPECT_NEAR(optical_path(100.0, 900.0, 5000.0).mie_m, optical_path(900.0, 100.0, 5000.0).mie_m, 1e-9);
}

}  // namespace
}  // namespace kasumi
