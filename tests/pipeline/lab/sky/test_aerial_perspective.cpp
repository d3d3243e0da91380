// Land drawn through the air, against the spectral atmosphere integrated along every line of sight.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "pipeline/lab/sky/dome_drawing.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

struct Sun {
  double zenith_deg, azimuth_deg;
};

class AerialPerspective : public testing::Test {
 protected:
  // Mean difference in steps of 255 over the land in a view to the north, for grey land as dark as woods and as bright
  // as snow.
  double mean_error(const reference::ReferenceSky& sky, double turbidity, double altitude_m, const Sun& sun) {
    Viewpoint camera;
    camera.width = 160;
    camera.height = 90;
    camera.pitch_deg = altitude_m > 1000.0 ? -6.0 : 2.0;
    DomeRequest request;
    request.turbidity = {turbidity};
    request.altitude_m = altitude_m;
    request.sun = direction_from(from_degrees(sun.zenith_deg), from_degrees(sun.azimuth_deg));
    const PanoramaView view = view_of(camera);
    const DomeScene scene = sky_scene(standing_on_land(camera, request));
    const DomePainter painter(scene);
    const auto land = land_for(camera, scene.altitude_m, true);
    const LandRayCaster sight(land->land, land->from, land->to);
    double sum = 0.0;
    int count = 0;
    for (int y = 4; y < camera.height; y += 9)
      for (int x = 6; x < camera.width; x += 14) {
        const Direction towards = direction_of(view, {x, y});
        const auto hit = sight.along(towards, scene.altitude_m);
        if (!hit || glm::length(hit->place) < 500.0) continue;
        const double length_m = glm::length(hit->place - glm::dvec3(0.0, 0.0, scene.altitude_m));
        const auto path = sky.along({scene.altitude_m, towards, scene.sun}, length_m);
        for (const double albedo : {0.05, 0.6}) {
          std::vector<double> light, seen;
          for (std::size_t w = 0; w < path.light.size(); ++w) {
            light.push_back(albedo / kPi * sky.diffuse().ground_flux(sun.zenith_deg, w));
            seen.push_back(light[w] * path.transmission[w] + path.light[w]);
          }
          const glm::dvec3 object = xyz_to_linear_srgb() * sky.xyz_of(light);
          const glm::dvec3 ours = painter.shown(painter.through_air(object, hit->place, hit->altitude_m));
          const glm::dvec3 truth = painter.shown(xyz_to_linear_srgb() * sky.xyz_of(seen));
          sum += 255.0 * glm::dot(glm::abs(ours - truth), glm::dvec3(1.0 / 3.0));
          ++count;
        }
      }
    EXPECT_GT(count, 30);
    const double error = sum / count;
    RecordProperty(fmt::format("steps_T{}_{}m_{}deg_{}deg", turbidity, altitude_m, sun.zenith_deg, sun.azimuth_deg),
                   fmt::format("{:.2f}", error));
    return error;
  }

  static reference::ReferenceSky atmosphere(double turbidity) {
    return reference::ReferenceSky(reference::Air{.aerosol = aerosol_of(turbidity)}, 40.0);
  }
};

TEST_F(AerialPerspective, MatchesTheSpectralAtmosphereFromThePlainAndFromTheMountains) {
  constexpr double kTurbidity = 2.5;
  const auto sky = atmosphere(kTurbidity);
  for (const double altitude_m : {0.0, 3000.0}) {
    double mean = 0.0;
    for (const Sun& sun : {Sun{40.0, 120.0}, {70.0, 60.0}, {70.0, 200.0}}) {
      const double error = mean_error(sky, kTurbidity, altitude_m, sun);
      mean += error / 3.0;
      EXPECT_LE(error, 1.5) << "steps of 255; " << altitude_m << " m, sun " << sun.zenith_deg
                            << " deg from the zenith, " << sun.azimuth_deg << " deg from the middle of the view";
    }
    EXPECT_LE(mean, altitude_m > 0.0 ? 1.2 : 0.6) << "steps of 255, " << altitude_m << " m";
  }
}

TEST_F(AerialPerspective, AlsoHoldsAtOtherAltitudesAndUnderOtherSunsAndAirs) {
  // Thicker air; the limits on means are over all altitudes and suns together.
  for (const double turbidity : figure_cases<double>("turbidities", {3.5}, {2.0, 3.5})) {
    const auto sky = atmosphere(turbidity);
    double mean = 0.0;
    for (const double altitude_m : {1800.0, 5000.0})
      for (const Sun& sun : {Sun{25.0, 150.0}, {55.0, 0.0}, {75.0, 100.0}}) {
        const double error = mean_error(sky, turbidity, altitude_m, sun);
        mean += error / 6.0;
        EXPECT_LE(error, 2.5) << "steps of 255; " << altitude_m << " m, T " << turbidity << ", sun " << sun.zenith_deg
                              << " deg from the zenith";
      }
    EXPECT_LE(mean, 1.8) << "steps of 255, T " << turbidity;
  }
}

}  // namespace
}  // namespace kasumi
