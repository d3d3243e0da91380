// The model to which the dome's T is fitted, against the dome itself.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/given_air.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/turbidity/solver.hpp"
#include "tests/estimator/turbidity/cramer_rao.hpp"
#include "tests/estimator/turbidity/dome_samples.hpp"

namespace kasumi::test {
namespace {

SunDirection sun_at_deg(double zenith_deg) {
  return direction_from(from_degrees(zenith_deg), from_degrees(170.0));
}

TEST(DomeLog, IsTheDomesLogarithmAndItsSlope) {
  double worst = 0.0, worst_slope = 0.0;
  for (const double altitude_m : {0.0, 3000.0})
    for (const double sun_deg : {20.0, 70.0}) {
      const SunDirection sun = sun_at_deg(sun_deg);
      const DomeLog log(altitude_m, sun);
      for (const double t : {1.7, 1.75, 2.1, 2.9, 4.4, 6.1, 9.7, 10.0})
        for (const Direction& view : {sun_at_deg(5.0), sun_at_deg(50.0), sun_at_deg(-40.0), sun_at_deg(79.0)}) {
          const auto nodes = log.at(view.z, std::cos(angle_between(view, sun).value));
          const auto log_y = [&](double at) {
            return std::log(dome_light(dome(altitude_m, Turbidity{at}, sun), view).y);
          };
          const auto between = log.between(Turbidity{t});
          worst = std::max(worst, std::abs(between.value_of(nodes) - log_y(t)));
          const double low = std::max(1.7, t - 1e-3), high = std::min(10.0, t + 1e-3);
          const double slope = (log_y(high) - log_y(low)) / (high - low);
          worst_slope = std::max(worst_slope, t * std::abs(between.slope_of(nodes) - slope));
        }
    }
  std::printf("worst error of ln Y %.5f, of d ln Y / d ln T %.4f\n", worst, worst_slope);
  EXPECT_LT(worst, 0.001);
  EXPECT_LT(worst_slope, 0.03);  // the dome's own cubics over the aerosol's amount meet with kinks
}

TEST(DomeLog, APerfectDomeIsFoundToItsHundredths) {
  for (const double altitude_m : {0.0, 3000.0})
    for (const double sun_deg : {30.0, 75.0})
      for (const double t : {1.7, 1.9, 2.6, 3.9, 5.5, 8.2, 9.8}) {
        const SunDirection sun = sun_at_deg(sun_deg);
        const DomeFunction sky = dome(altitude_m, Turbidity{t}, sun);
        const auto samples = samples_of([&](const Direction& view) { return dome_light(sky, view).y; }, sun, 400, 0.0);
        const auto found = solve_turbidity(samples, {}, FittedSky({DaylightModel::dome, altitude_m}, sun));
        EXPECT_TRUE(found.solved);
        EXPECT_FALSE(found.at_edge) << t;
        EXPECT_NEAR(found.turbidity.value / t, 1.0, 0.005) << t << ", sun " << sun_deg << ", " << altitude_m << " m";
      }
}

// From nearly none of it: of a kind, the amount alone is unknown.
TEST(DomeLog, TheAmountOfAGivenKindIsFound) {
  for (const AerosolKind kind : {AerosolKind::continental, AerosolKind::dust, AerosolKind::smoke})
    for (const double sun_deg : {35.0, 70.0})
      for (const double aod : {0.01, 0.05, 0.2, 0.6}) {
        const SunDirection sun = sun_at_deg(sun_deg);
        const Aerosol aerosol{aod, natural_exponent(kind), kind};
        const DomeFunction sky = dome(0.0, aerosol, sun);
        const auto samples = samples_of([&](const Direction& view) { return dome_light(sky, view).y; }, sun, 400, 0.0);
        const ModelToFit fit{DaylightModel::dome, 0.0, Aerosol{0.0, natural_exponent(kind), kind}};
        const auto found = solve_turbidity(samples, {}, FittedSky(fit, sun));
        EXPECT_TRUE(found.solved);
        EXPECT_NEAR(air_of(found.turbidity, fit.aerosol).aerosol().aod_550, aod, 0.001 + 0.01 * aod)
            << name_of(kind) << ", sun " << sun_deg;
      }
}

TEST(DomeLog, ASkyHazierThanAllDomesIsAtTheEdgeAndAClearerOneIsNot) {
  const SunDirection sun = sun_at_deg(50.0);
  const FittedSky sky({DaylightModel::dome, 0.0}, sun);
  // Extrapolated beyond the table at the table's own slope.
  const auto beyond = [&](double inside, double end, double by) {
    const DomeFunction a = dome(0.0, Turbidity{inside}, sun), b = dome(0.0, Turbidity{end}, sun);
    const auto y = [&](const Direction& view) {
      return dome_light(b, view).y * std::pow(dome_light(b, view).y / dome_light(a, view).y, by);
    };
    return solve_turbidity(samples_of(y, sun, 400, 0.002), {}, sky);
  };
  const auto hazier = beyond(8.0, 10.0, 1.0), clearer = beyond(2.0, 1.7, 1.0);
  EXPECT_TRUE(hazier.at_edge);
  EXPECT_NEAR(hazier.turbidity.value, 10.0, 1e-6);
  EXPECT_FALSE(clearer.at_edge);
  EXPECT_NEAR(clearer.turbidity.value, 1.7, 1e-6);
}

TEST(DomeLog, NoiseScattersTAsTheBoundSays) {
  const SunDirection sun = sun_at_deg(60.0);
  const DomeFunction dome_4 = dome(0.0, Turbidity{4.0}, sun);
  const FittedSky sky({DaylightModel::dome, 0.0}, sun);
  double squares = 0.0, bound = 0.0;
  constexpr int kSkies = 60;
  for (int seed = 0; seed < kSkies; ++seed) {
    const auto samples = samples_of([&](const Direction& view) { return dome_light(dome_4, view).y; }, sun, 400, 0.01,
                                    static_cast<std::uint64_t>(seed));
    squares += std::pow(solve_turbidity(samples, {}, sky).turbidity.value - 4.0, 2) / kSkies;
    bound += cramer_rao_sigma(samples, Turbidity{4.0}, false, sky) / kSkies;
  }
  std::printf("T 4, 1 %% noise, 400 samples: +- %.4f, bound %.4f\n", std::sqrt(squares), bound);
  EXPECT_LT(std::sqrt(squares), 1.25 * bound);
  EXPECT_GT(std::sqrt(squares), 0.75 * bound);
}

}  // namespace
}  // namespace kasumi::test
