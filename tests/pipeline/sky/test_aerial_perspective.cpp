// Land through the air, as it is drawn, against the spectral atmosphere followed along every line of sight.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "estimator/dome.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "pipeline/sky_drawing.hpp"

namespace kasumi {
namespace {

class AerialPerspective : public testing::Test {
 protected:
  // Mean difference in steps of 255 over the land in a view, for grey land as dark as woods and as bright as snow.
  double mean_error(double altitude_m, double sun_zenith_deg, double sun_azimuth_deg) const {
    SkyCamera camera;
    camera.width = 160;
    camera.height = 90;
    camera.pitch_deg = altitude_m > 1000.0 ? -6.0 : 2.0;
    SkyRequest request;
    request.turbidity = {kTurbidity};
    request.altitude_m = altitude_m;
    request.sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(sun_azimuth_deg));
    const SkyView view = view_of(camera);
    const SkyScene scene = sky_scene(standing_on_land(camera, request));
    const SkyPainter painter(scene);
    const auto land = land_for(camera, scene.altitude_m, true);
    const LandSight sight(land->land, land->from, land->to);
    double sum = 0.0;
    int count = 0;
    for (int y = 4; y < camera.height; y += 9)
      for (int x = 6; x < camera.width; x += 14) {
        const Direction towards = direction_of(view, {x, y});
        const auto hit = sight.along(towards, scene.altitude_m);
        if (!hit || glm::length(hit->place) < 500.0) continue;
        const double length_m = glm::length(hit->place - glm::dvec3(0.0, 0.0, scene.altitude_m));
        const auto path = sky_.along({scene.altitude_m, towards, scene.sun}, length_m);
        for (const double albedo : {0.05, 0.6}) {
          std::vector<double> light, seen;
          for (std::size_t w = 0; w < path.light.size(); ++w) {
            light.push_back(albedo / kPi * sky_.diffuse().ground_flux(sun_zenith_deg, w));
            seen.push_back(light[w] * path.transmission[w] + path.light[w]);
          }
          const glm::dvec3 object = xyz_to_linear_srgb() * sky_.xyz_of(light);
          const glm::dvec3 ours = painter.shown(painter.through_air(object, hit->place, hit->altitude_m));
          const glm::dvec3 truth = painter.shown(xyz_to_linear_srgb() * sky_.xyz_of(seen));
          sum += 255.0 * glm::dot(glm::abs(ours - truth), glm::dvec3(1.0 / 3.0));
          ++count;
        }
      }
    EXPECT_GT(count, 30);
    return sum / count;
  }

  static constexpr double kTurbidity = 2.5;
  const reference::ReferenceSky sky_{reference::Air{.turbidity = kTurbidity}, 40.0};
};

TEST_F(AerialPerspective, IsTheSpectralAtmospheresFromThePlainAndFromTheMountains) {
  double mean_of_both = 0.0;
  for (const double altitude_m : {0.0, 3000.0}) {
    double mean = 0.0;
    for (const auto& [zenith_deg, azimuth_deg] :
         {std::pair(40.0, 120.0), std::pair(70.0, 60.0), std::pair(70.0, 200.0)}) {
      const double error = mean_error(altitude_m, zenith_deg, azimuth_deg);
      mean += error / 3.0;
      RecordProperty(fmt::format("steps_{}m_{}deg_{}deg", altitude_m, zenith_deg, azimuth_deg),
                     fmt::format("{:.2f}", error));
      EXPECT_LE(error, 4.0) << "steps of 255; " << altitude_m << " m, sun " << zenith_deg << " deg from the zenith, "
                            << azimuth_deg << " deg from the middle of the view";
    }
    EXPECT_LE(mean, altitude_m > 0.0 ? 3.3 : 1.5) << "steps of 255, " << altitude_m << " m";
    mean_of_both += mean / 2.0;
  }
  EXPECT_LE(mean_of_both, 3.0) << "steps of 255";
}

}  // namespace
}  // namespace kasumi
