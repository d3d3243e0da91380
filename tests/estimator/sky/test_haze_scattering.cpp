// Two lobes and three albedos against the Mie sums of each kind of aerosol.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "base/units.hpp"
#include "estimator/sky/haze_scattering.hpp"
#include "fixtures/aerosol/kinds.hpp"

namespace kasumi {
namespace {

double lobes_at(const sky_text::HazeScattering& haze, double cosine) {
  return haze.height.x * sky_text::dome_lobe(haze.asymmetry.x, cosine) +
         haze.height.y * sky_text::dome_lobe(haze.asymmetry.y, cosine);
}

class HazeScatteringOf : public testing::TestWithParam<AerosolKind> {};

TEST_P(HazeScatteringOf, ScattersAllThatItDoesNotAbsorb) {
  const auto haze = haze_scattering(GetParam());
  constexpr int kSteps = 20000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += lobes_at(haze, (i + 0.5) / kSteps * 2.0 - 1.0) / kSteps;
  EXPECT_NEAR(sum, 1.0, 1e-3);
}

TEST_P(HazeScatteringOf, IsNearTheMieSums) {
  const auto haze = haze_scattering(GetParam());
  double squares = 0.0;
  int count = 0;
  for (double deg = 3.0; deg <= 170.0; deg += 1.0, ++count) {
    const double cosine = std::cos(from_degrees(deg).value);
    squares += std::pow(std::log(lobes_at(haze, cosine) / reference::phase(GetParam(), 550.0, cosine)), 2);
  }
  const double rms = std::sqrt(squares / count);
  std::printf("%-12s rms of ln p, 3 to 170 deg: %.3f\n", std::string(name_of(GetParam())).c_str(), rms);
  EXPECT_LE(rms, GetParam() == AerosolKind::dust ? 0.30 : 0.20);
  const double nm[] = {610.0, 550.0, 465.0};
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(haze.albedo[c], reference::single_scattering_albedo(GetParam(), nm[c]), 0.002) << nm[c] << " nm";
}

INSTANTIATE_TEST_SUITE_P(Kinds, HazeScatteringOf, testing::ValuesIn(kAerosolKinds),
                         [](const auto& kind) { return std::string(name_of(kind.param)); });

}  // namespace
}  // namespace kasumi
