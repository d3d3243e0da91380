// The light that the air of a finite path adds, against the spectral atmosphere followed along it.
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/earth.hpp"
#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/light/finite_path.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

struct PathCase {
  double altitude_m, turbidity, sun_elevation_deg;
};

// The largest errors of (1 - Gamma) Linf with and without the factor, in parts of Linf.
struct PathErrors {
  double level = 0.0, mended = 0.0;
};

PathErrors errors_of(const PathCase& at) {
  const Aerosol aerosol =
      aerosol_of(at.turbidity, natural_exponent(AerosolKind::continental), AerosolKind::continental);
  const reference::ReferenceSky truth(reference::Air{.aerosol = aerosol});
  const Direction sun = direction_from(from_degrees(90.0 - at.sun_elevation_deg), from_degrees(240.0));
  const AirState air{aerosol};
  const glm::dmat3 to_srgb = xyz_to_linear_srgb();
  const FinitePath paths(SiteSky(DaylightModel::dome, air, sun, at.altitude_m), air, sun, at.altitude_m, to_srgb);
  const auto srgb = [&](const std::vector<double>& light) { return to_srgb * truth.xyz_of(light); };
  PathErrors worst;
  for (const double elevation_deg : {-0.5, 0.4, 1.3, 2.6})
    for (const double azimuth_deg : {10.0, 120.0})
      for (const double distance_m : {700.0, 2500.0, 9000.0}) {
        const reference::View view{at.altitude_m,
                                   direction_from(from_degrees(90.0 - elevation_deg), from_degrees(azimuth_deg)), sun};
        const double rise_m = distance_m * view.direction.z + distance_m * distance_m / (2.0 * kEarthRadius_m);
        if (view.direction.z < reference::horizon_cosine(at.altitude_m)) continue;  // no sky behind the path
        const auto path = truth.along(view, distance_m);
        const glm::dvec3 infinite = srgb(truth.radiance(view));
        const glm::dvec3 gamma = srgb(path.transmission) / srgb(std::vector<double>(path.transmission.size(), 1.0));
        const glm::dvec3 factor = paths.factor(view.direction, rise_m, gamma);
        const glm::dvec3 added = srgb(path.light) / infinite;
        for (int c = 0; c < 3; ++c) {
          worst.level = std::max(worst.level, std::abs(1.0 - gamma[c] - added[c]));
          worst.mended = std::max(worst.mended, std::abs(factor[c] * (1.0 - gamma[c]) - added[c]));
        }
      }
  return worst;
}

TEST(AirTruthLight, TheAirOfAPathAddsWhatTheSpectralAtmosphereAdds) {
  const std::vector<PathCase> all{{30.0, 1.7, 9.0},    {30.0, 3.1, 5.0},   {450.0, 2.3, 6.0},  {450.0, 6.5, 14.0},
                                  {1300.0, 2.6, 11.0}, {1300.0, 1.5, 4.0}, {200.0, 2.8, 35.0}, {2100.0, 2.2, 60.0}};
  fmt::print(
      "light added by air before an object, in parts of the light from infinity (goal .03):\n"
      "| altitude, T, sun | (1 - Gamma) | with the path's own light |\n");
  double worst_of_all = 0.0;
  for (const PathCase& at : figure_cases("altitudes, airs and suns", {all[2], all[5], all[6]}, all)) {
    const PathErrors worst = errors_of(at);
    worst_of_all = std::max(worst_of_all, worst.mended);
    fmt::print("| {} m, T {}, {} deg high | {:.3f} | {:.3f} |\n", at.altitude_m, at.turbidity, at.sun_elevation_deg,
               worst.level, worst.mended);
    EXPECT_LE(worst.mended, 0.03) << at.altitude_m << " m, T " << at.turbidity;
  }
  figure_row("given-light", {"what the air before an object adds, in parts of the light from infinity, worst",
                             figure_text(worst_of_all, 2), ".03", "`test_air_truth_light`"});
}

}  // namespace
}  // namespace kasumi
