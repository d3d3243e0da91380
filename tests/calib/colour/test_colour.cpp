#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colour/camera_saturation.hpp"
#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

struct Chromaticity {
  double x, y;
};

template <class Spectrum>
glm::dvec3 xyz_of(const Spectrum& spectrum, double step_nm = 5.0) {
  glm::dvec3 xyz{0.0};
  for (double nm = 380.0; nm <= 780.0; nm += step_nm) xyz += step_nm * spectrum(nm) * colour_matching(nm);
  return xyz;
}
Chromaticity chromaticity_of(const glm::dvec3& xyz) {
  return {xyz.x / (xyz.x + xyz.y + xyz.z), xyz.y / (xyz.x + xyz.y + xyz.z)};
}

// CIE 15: the daylight locus.
Chromaticity daylight_of_temperature(double kelvin) {
  const double u = 1e3 / kelvin;
  const double x = kelvin <= 7000.0 ? 0.244063 + u * (0.09911 + u * (2.9678 - 4.6070 * u))
                                    : 0.237040 + u * (0.24748 + u * (1.9018 - 2.0064 * u));
  return {x, -3.0 * x * x + 2.87 * x - 0.275};
}

TEST(ColourMatching, HasTheStandardObserversPublishedIntegrals) {
  const auto sum = xyz_of([](double) { return 1.0; });
  EXPECT_NEAR(sum.y, 106.857, 1e-3);
  const auto white = chromaticity_of(sum);
  EXPECT_NEAR(white.x, 1.0 / 3.0, 5e-6);
  EXPECT_NEAR(white.y, 1.0 / 3.0, 5e-6);
}

TEST(ColourMatching, PeaksWhereTheEyeDoesAndIsZeroOutsideTheVisibleRange) {
  EXPECT_EQ(colour_matching(555.0).y, 1.0);
  EXPECT_NEAR(colour_matching(557.5).y, 0.5 * (1.0 + 0.995), 1e-12);
  EXPECT_EQ(colour_matching(379.0), glm::dvec3(0.0));
  EXPECT_EQ(colour_matching(781.0), glm::dvec3(0.0));
}

// The CIE's illuminants as tabulated, from the weights it publishes (rounded to three decimals, hence the tolerance).
TEST(Daylight, TheComponentsGiveTheTabulatedD65AndD50) {
  struct Row {
    double nm, d65, d50;
  };
  for (const auto& [nm, d65, d50] :
       {Row{380, 49.9755, 24.49},  Row{400, 82.7549, 49.31}, Row{420, 93.4318, 60.03}, Row{440, 104.865, 74.82},
        Row{460, 117.812, 90.61},  Row{480, 115.923, 95.11}, Row{500, 109.354, 95.72}, Row{520, 104.790, 97.13},
        Row{540, 104.405, 100.75}, Row{560, 100.000, 100.0}, Row{580, 95.7880, 98.92}, Row{600, 90.0062, 97.69},
        Row{620, 87.6987, 99.04},  Row{640, 83.6992, 98.86}, Row{660, 80.2146, 98.19}, Row{680, 78.2842, 99.13},
        Row{700, 71.6091, 91.60},  Row{720, 61.6040, 76.85}, Row{740, 75.0870, 92.58}, Row{760, 46.4182, 57.69},
        Row{780, 63.3828, 78.27}}) {
    const auto s = daylight_components(nm);
    EXPECT_NEAR(s[0] - 0.296 * s[1] - 0.688 * s[2], d65, 0.05) << nm;
    EXPECT_NEAR(s[0] - 1.040 * s[1] + 0.367 * s[2], d50, 0.06) << nm;
  }
}

TEST(Daylight, TheChromaticityOfItsSpectrumIsTheRequestedOne) {
  const auto d65 = chromaticity_of(xyz_of([](double nm) { return daylight_spectrum(0.31272, 0.32903, nm); }));
  EXPECT_NEAR(d65.x, 0.31272, 2e-4);
  EXPECT_NEAR(d65.y, 0.32903, 2e-4);
  for (const double kelvin : {4000.0, 5000.0, 6500.0, 10000.0, 25000.0}) {
    const auto [x, y] = daylight_of_temperature(kelvin);
    const auto found = chromaticity_of(xyz_of([&](double nm) { return daylight_spectrum(x, y, nm); }));
    EXPECT_NEAR(found.x, x, 1e-3) << kelvin;
    EXPECT_NEAR(found.y, y, 1e-3) << kelvin;
  }
}

std::vector<SpectralSensitivity> cameras() {
  std::vector<SpectralSensitivity> cameras{generic_sensitivity()};
  const fs::path folder = shared_data_folder() / "spectral";
  if (!fs::exists(folder)) return cameras;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".json" || entry.path().extension() == ".csv") {
      auto camera = read_spectral_sensitivity(entry.path());
      EXPECT_TRUE(camera) << camera.error().message;
      if (camera) cameras.push_back(*camera);
    }
  EXPECT_EQ(cameras.size(), 7U);
  return cameras;
}

TEST(CameraToXyz, IsExactForEveryMixtureOfDaylights) {
  for (const auto& camera : cameras()) {
    const auto matrix = camera_to_xyz(camera);
    EXPECT_TRUE(separates_daylight(camera)) << camera.name;
    for (const double warm : {0.0, 0.2, 0.7, 1.0}) {
      const auto a = daylight_of_temperature(4000.0), b = daylight_of_temperature(25000.0);
      const auto light = [&](double nm) {
        return warm * daylight_spectrum(a.x, a.y, nm) + (1.0 - warm) * 3.0 * daylight_spectrum(b.x, b.y, nm);
      };
      glm::dvec3 seen{0.0};
      for (double nm = 380.0; nm <= 780.0; nm += 1.0) seen += light(nm) * camera.at(nm);
      const auto xyz = xyz_of(light, 1.0);
      EXPECT_LE(glm::distance(matrix * seen, xyz), 1e-9 * glm::length(xyz)) << camera.name;
    }
  }
}

// A camera whose sensitivities are linear combinations of the observer's (Luther condition) measures every colour
// correctly, daylight or not.
TEST(CameraToXyz, InvertsACameraThatMeetsTheLutherCondition) {
  const glm::dmat3 mixing{2.0, 0.3, 0.1, 0.5, 1.5, 0.2, 0.1, 0.4, 1.1};
  SpectralSensitivity camera{"luther", 380.0, 5.0, {}};
  for (double nm = 380.0; nm <= 780.0; nm += 5.0) camera.samples.push_back(mixing * colour_matching(nm));
  const auto matrix = camera_to_xyz(camera) * mixing;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(matrix[i][j], i == j ? 1.0 : 0.0, 1e-9);
}

TEST(CameraToXyz, AGreyCameraCannotDistinguishDaylights) {
  SpectralSensitivity grey{"grey", 380.0, 5.0, {}};
  for (double nm = 380.0; nm <= 780.0; nm += 5.0) grey.samples.emplace_back(colour_matching(nm).y);
  EXPECT_FALSE(separates_daylight(grey));
}

TEST(SrgbReflectance, WhiteStaysWhiteAndGreyGreyForEveryCamera) {
  const auto matrix = srgb_reflectance_to_channels(generic_sensitivity());
  for (const double grey : {0.18, 1.0})
    for (int c = 0; c < 3; ++c) EXPECT_NEAR((matrix * glm::dvec3{grey})[c], grey, 1e-9);
}

TEST(SrgbReflectance, ACameraThatSeesLikeSrgbSeesTheColourItself) {
  // Channels that are linear sRGB's own curves: the reflectance per channel is then the colour itself, for any
  // spectrum.
  SpectralSensitivity srgb{"sRGB", 380.0, 5.0, {}};
  const glm::dmat3 from_xyz = glm::inverse(srgb_to_xyz());
  for (double nm = 380.0; nm <= 780.0; nm += 5.0) srgb.samples.push_back(from_xyz * colour_matching(nm));
  const auto matrix = srgb_reflectance_to_channels(srgb);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) EXPECT_NEAR(matrix[column][row], column == row ? 1.0 : 0.0, 1e-9);
}

TEST(SrgbReflectance, ABroadGreenChannelSeesPartOfARedWall) {
  const glm::dvec3 seen = srgb_reflectance_to_channels(generic_sensitivity()) * glm::dvec3{1.0, 0.0, 0.0};
  EXPECT_GT(seen.r, 0.5);
  EXPECT_GT(seen.r, seen.g);
  EXPECT_GT(seen.g, -0.2);
  EXPECT_LT(std::abs(seen.b), 0.2);
}

TEST(SrgbToXyz, WhiteIsD65AndThePrimariesAreThoseOfTheStandard) {
  const auto matrix = srgb_to_xyz();
  const auto white = chromaticity_of(matrix * glm::dvec3{1.0});
  EXPECT_NEAR(white.x, 0.3127, 1e-4);
  EXPECT_NEAR(white.y, 0.3290, 1e-4);
  const Chromaticity primaries[] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
  for (int c = 0; c < 3; ++c) {
    const auto found = chromaticity_of(matrix[c]);
    EXPECT_NEAR(found.x, primaries[c].x, 2e-4);
    EXPECT_NEAR(found.y, primaries[c].y, 2e-4);
  }
  EXPECT_NEAR((matrix * glm::dvec3{1.0}).y, 1.0, 1e-12);
}

TEST(Saturation, MovesColoursAwayFromGreyAndBack) {
  const glm::dvec3 grey{0.4}, sky{0.3, 0.5, 0.8};
  EXPECT_NEAR(glm::distance(with_saturation(grey, 1.7), grey), 0.0, 1e-12);
  const auto more = with_saturation(sky, 1.7);
  EXPECT_LT(more.r, sky.r);
  EXPECT_GT(more.b, sky.b);
  EXPECT_NEAR(glm::dot(more, kLuminanceOfSrgb), glm::dot(sky, kLuminanceOfSrgb), 1e-12);
  EXPECT_NEAR(glm::distance(with_saturation(more, 1.0 / 1.7), sky), 0.0, 1e-12);
}

}  // namespace
}  // namespace kasumi
