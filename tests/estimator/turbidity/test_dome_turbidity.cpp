// Preetham's estimator on skies that are not Preetham's: the T it finds in a dome of known aerosol.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/figures.hpp"

namespace kasumi::test {
namespace {

Image<Rgb8> picture_of(const DomeFunction& sky, const SunDirection& sun, const Camera& camera) {
  const DomeFunction in_rgb = in_space(sky, xyz_to_linear_srgb());
  Image<glm::dvec3> light(camera.width, camera.height);
  double brightest = 0.0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto view = camera.direction_at({x, y});
      if (!view || view->z <= 0.0) continue;
      const double gamma = angle_between(*view, sun).value;
      light.at(x, y) = gamma < from_degrees(0.27).value ? glm::dvec3{1e9} : glm::max(dome_light(in_rgb, *view), 0.0);
      const auto& at = light.at(x, y);
      if (gamma > from_degrees(10.0).value) brightest = std::max({brightest, at.x, at.y, at.z});
    }
  Image<Rgb8> picture(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const glm::dvec3 encoded = camera.response.to_encoded(glm::clamp(light.at(x, y) / brightest, 0.0, 1.0));
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(255.0 * encoded[c]));
      }
  return picture;
}

TurbidityEstimate estimate_in(double altitude_m, double turbidity, double sun_zenith_deg, const Camera& camera) {
  const SunDirection sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(170.0));
  const auto picture = picture_of(dome(altitude_m, Turbidity{turbidity}, sun), sun, camera);
  return estimate_turbidity(*sky_picture(view_of(picture), camera), camera, sun);
}

TEST(DomeTurbidity, TheEstimateRisesWithTheTrueAerosol) {
  const Camera camera = upward_camera(240);
  for (const double altitude_m : {0.0, 3000.0}) {
    fmt::print("altitude {:.0f} m; sun's zenith angle, then T estimated at T 1.7 2 2.5 3 4 6 8 10 of the dome\n",
               altitude_m);
    for (const double sun_zenith_deg : {30.0, 45.0, 60.0, 75.0}) {
      fmt::print("{:3.0f} deg:", sun_zenith_deg);
      double before = 0.0;
      std::vector<std::string> cells{fmt::format("{} m, {} deg", altitude_m, sun_zenith_deg)};
      for (const double turbidity : {1.7, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0}) {
        const auto found = estimate_in(altitude_m, turbidity, sun_zenith_deg, camera);
        fmt::print("  {}{:.2f}", found.usable ? "" : "(no) ", found.turbidity.value);
        cells.push_back(fmt::format(fmt::runtime(found.usable ? "{:.2f}" : "({:.2f})"), found.turbidity.value));
        if (!found.usable) continue;
        // Higher up there is too little aerosol left for Preetham's skies to resolve it.
        if (altitude_m == 0.0) {
          // Below 4 the steps are smaller than the scatter of an estimate.
          EXPECT_GT(found.turbidity.value, before + (turbidity >= 4.0 ? 0.02 : -0.08))
              << turbidity << ", " << sun_zenith_deg;
        }
        before = found.turbidity.value;
      }
      fmt::print("\n");
      figure_row("two-turbidities", cells);
    }
  }
}

}  // namespace
}  // namespace kasumi::test
