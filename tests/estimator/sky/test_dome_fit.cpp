// The estimator with the dome as its sky: in pictures of domes with a known aerosol, and in the spectral atmosphere's
// skies between the grid points to which the dome was fitted.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/sky/dome.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "tests/estimator/turbidity/cramer_rao.hpp"
#include "tests/estimator/turbidity/dome_samples.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/figures.hpp"

namespace kasumi::test {
namespace {

struct Found {
  TurbidityEstimate estimate;
  double bound = 0.0;
};
// 8 bits of sRGB with the sun's disc and shot noise.
Found look_at(double altitude_m, double turbidity, double sun_zenith_deg, double clouds, SiteSkyModel fitted) {
  static const Camera camera = upward_camera(200);
  SyntheticSky description;
  description.sun_zenith_deg = sun_zenith_deg;
  description.cloud_cover = clouds;
  description.cloud_seed = 3;
  description.noise = 0.005;
  const SunDirection sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(description.sun_azimuth_deg));
  const DomeFunction sky = dome(altitude_m, Turbidity{turbidity}, sun);
  description.clear = [&](const Direction& view) { return 1e-3 * dome_light(sky, view); };
  const auto picture = render(description, camera).to_8_bit();
  EstimateOptions options;
  options.sky = {fitted, altitude_m};
  const auto look = SkyObserver(camera).observe(*sky_picture(view_of(picture), camera), sun, options);
  return {look.estimate, cramer_rao_sigma(look.samples, Turbidity{turbidity}, false, FittedSky(options.sky, sun))};
}

class DomeFit : public testing::TestWithParam<double> {};

TEST_P(DomeFit, ThePicturesOfADomeTellItsAerosol) {
  const double clouds = GetParam();
  // The limits of the table.
  const auto suns_deg = figure_cases<double>("suns", {30.0, 75.0}, {30.0, 52.0, 75.0});
  const auto turbidities = figure_cases<double>("turbidities", {1.7, 9.5}, {1.7, 2.0, 3.0, 5.0, 9.5});
  for (const double altitude_m : {0.0, 3000.0})
    for (const double sun_zenith_deg : suns_deg) {
      fmt::print("{:.0f} % clouds, {:4.0f} m, sun {:.0f} deg:", 100 * clouds, altitude_m, sun_zenith_deg);
      for (const double turbidity : turbidities) {
        const auto [found, bound] = look_at(altitude_m, turbidity, sun_zenith_deg, clouds, SiteSkyModel::dome);
        fmt::print("  {} {:.2f} +- {:.2f} ({:.2f})", turbidity, found.turbidity.value, found.sigma, bound);
        EXPECT_TRUE(found.usable) << found.reason;
        EXPECT_LT(std::abs(found.turbidity.value - turbidity), 0.02 * turbidity);
      }
      fmt::print("\n");
    }
}
INSTANTIATE_TEST_SUITE_P(Clouds, DomeFit, testing::Values(0.0, 0.3));

TEST(DomeFit, SkiesOfTheSpectralAtmosphereAreFoundBetweenTheNodesOfTheTable) {
  for (const double turbidity : figure_cases<double>("turbidities", {8.2}, {2.0, 3.9, 8.2})) {
    const reference::ReferenceSky atmosphere(reference::Air{.aerosol = aerosol_of(turbidity)}, 40.0);
    for (const double altitude_m : {400.0, 2200.0})
      for (const double sun_zenith_deg : {33.0, 68.0}) {
        const SunDirection sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(0.0));
        const auto samples = samples_of(
            [&](const Direction& view) {
              return atmosphere.xyz({altitude_m, view, sun}).y;
            },
            sun, 300, 0.005);
        const FittedSky sky({SiteSkyModel::dome, altitude_m}, sun);
        const auto found = solve_turbidity(samples, {}, sky);
        const auto preetham = solve_turbidity(samples);
        fmt::print(
            "T {}, {:.0f} m, sun {:.0f} deg: {:.3f} +- {:.3f} (bound {:.3f}), residual {:.2f} %; Preetham's {:.2f}, "
            "residual {:.1f} %\n",
            turbidity, altitude_m, sun_zenith_deg, found.turbidity.value, found.sigma,
            cramer_rao_sigma(samples, Turbidity{turbidity}, false, sky), 100 * found.log_residual,
            preetham.turbidity.value, 100 * preetham.log_residual);
        EXPECT_LT(std::abs(found.turbidity.value - turbidity), 0.05 * turbidity);
      }
  }
}

}  // namespace
}  // namespace kasumi::test
