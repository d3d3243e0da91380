// The estimator with the dome as its sky: in pictures of domes with a known aerosol, and in the spectral atmosphere's
// skies between the grid points to which the dome was fitted.
#include <cmath>
#include <map>

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
Found look_at(double altitude_m, double turbidity, double sun_zenith_deg, double clouds, DaylightModel fitted) {
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
  EstimateParameters options;
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
  std::vector<double> worst(turbidities.size()), sigma(turbidities.size()), least(turbidities.size(), 1e9);
  for (const double altitude_m : {0.0, 3000.0})
    for (const double sun_zenith_deg : suns_deg) {
      fmt::print("{:.0f} % clouds, {:4.0f} m, sun {:.0f} deg:", 100 * clouds, altitude_m, sun_zenith_deg);
      for (std::size_t i = 0; i < turbidities.size(); ++i) {
        const double turbidity = turbidities[i];
        const auto [found, bound] = look_at(altitude_m, turbidity, sun_zenith_deg, clouds, DaylightModel::dome);
        fmt::print("  {} {:.2f} +- {:.2f} ({:.2f})", turbidity, found.turbidity.value, found.sigma, bound);
        EXPECT_TRUE(found.usable) << found.reason;
        EXPECT_LT(std::abs(found.turbidity.value - turbidity), 0.02 * turbidity);
        worst[i] = std::max(worst[i], std::abs(found.turbidity.value - turbidity));
        sigma[i] = std::max(sigma[i], found.sigma);
        least[i] = std::min(least[i], bound);
      }
      fmt::print("\n");
    }
  const std::string sky = clouds > 0.0 ? fmt::format("{:.0f} % clouds", 100.0 * clouds) : "clear";
  std::vector<std::string> errors{sky + ", worst error"}, sigmas{sky + ", largest sigma; least Cramer-Rao bound"};
  for (std::size_t i = 0; i < turbidities.size(); ++i) {
    errors.push_back(figure_text(worst[i], 2));
    sigmas.push_back(figure_text(sigma[i], 2) + "; " + figure_text(least[i], 2));
  }
  figure_row("dome-pictures", errors);
  figure_row("dome-pictures", sigmas);
}
INSTANTIATE_TEST_SUITE_P(Clouds, DomeFit, testing::Values(0.0, 0.3));

TEST(DomeFit, SkiesOfTheSpectralAtmosphereAreFoundBetweenTheNodesOfTheTable) {
  for (const double turbidity : figure_cases<double>("turbidities", {8.2}, {2.0, 3.9, 8.2})) {
    const reference::ReferenceSky atmosphere(reference::Air{.aerosol = aerosol_of(turbidity)}, 40.0);
    std::map<double, std::string> by_altitude;
    double least = 1e9, most = 0.0, least_left = 1e9, most_left = 0.0;  // Preetham's T, and what he leaves
    for (const double altitude_m : {400.0, 2200.0})
      for (const double sun_zenith_deg : {33.0, 68.0}) {
        const SunDirection sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(0.0));
        const auto samples = samples_of(
            [&](const Direction& view) {
              return atmosphere.xyz({altitude_m, view, sun}).y;
            },
            sun, 300, 0.005);
        const FittedSky sky({DaylightModel::dome, altitude_m}, sun);
        const auto found = solve_turbidity(samples, {}, sky);
        const auto preetham = solve_turbidity(samples);
        fmt::print(
            "T {}, {:.0f} m, sun {:.0f} deg: {:.3f} +- {:.3f} (bound {:.3f}), residual {:.2f} %; Preetham's {:.2f}, "
            "residual {:.1f} %\n",
            turbidity, altitude_m, sun_zenith_deg, found.turbidity.value, found.sigma,
            cramer_rao_sigma(samples, Turbidity{turbidity}, false, sky), 100 * found.log_residual,
            preetham.turbidity.value, 100 * preetham.log_residual);
        EXPECT_LT(std::abs(found.turbidity.value - turbidity), 0.05 * turbidity);
        auto& text = by_altitude[altitude_m];
        text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", found.turbidity.value);
        least = std::min(least, preetham.turbidity.value);
        most = std::max(most, preetham.turbidity.value);
        least_left = std::min(least_left, preetham.log_residual);
        most_left = std::max(most_left, preetham.log_residual);
      }
    figure_row("dome-spectral", {fmt::format("T {:.1f}", turbidity), by_altitude[400.0], by_altitude[2200.0],
                                 fmt::format("{:.2f} to {:.2f}, residual {:.0f} to {:.0f} %", least, most,
                                             100.0 * least_left, 100.0 * most_left)});
  }
}

}  // namespace
}  // namespace kasumi::test
