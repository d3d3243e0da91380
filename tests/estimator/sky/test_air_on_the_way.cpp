// The air before land holds under every sun and in every air that can be asked for.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/common.hpp>

#include "estimator/sky/sky_scene.hpp"

namespace kasumi {
namespace {

TEST(AirOnTheWay, IsLightUnderEverySunAndInEveryAir) {
  for (const double aod_550 : {0.0, 0.02, 0.3, 1.8})
    for (const double sun_zenith_deg : {0.0, 0.5, 30.0, 80.0, 90.0, 97.0})
      for (const double altitude_m : {0.0, 300.0, 3600.0, 12000.0, 30000.0}) {
        DomeRequest request;
        request.like = Aerosol{aod_550, 1.3, AerosolKind::dust};
        request.turbidity = {turbidity_of(*request.like)};
        request.altitude_m = altitude_m;
        request.sun = direction_from(from_degrees(sun_zenith_deg), Radians{1.0});
        const DomeScene scene = sky_scene(request);
        const DomePainter painter(scene);
        for (const double down : {-0.3, 0.02, 0.2, 0.9}) {
          const double end_m = altitude_m * 0.4, length_m = std::max(altitude_m - end_m, 500.0) / std::abs(down);
          const glm::dvec3 view(0.0, std::sqrt(1.0 - down * down), -down);
          const glm::dvec3 place = glm::dvec3(0.0, 0.0, altitude_m) + length_m * view;
          const glm::dvec3 seen = painter.through_air(glm::dvec3(100.0), place, down < 0.0 ? place.z : end_m);
          EXPECT_TRUE(std::isfinite(seen.x + seen.y + seen.z));
          EXPECT_LT(glm::max(seen.x, glm::max(seen.y, seen.z)), 6e4)  // cd/m2; lit snow is half as bright
              << aod_550 << ", sun " << sun_zenith_deg << " deg from the zenith, " << altitude_m << " m, " << down;
        }
      }
}

TEST(AirOnTheWay, HasNoDepartureWhereTheSkiesAreKnown) {
  const glm::dvec3 early(0.3), late(-0.2);
  for (const double way : {0.0, 1.0}) EXPECT_EQ(sky_text::departure(early, late, way), glm::dvec3(0.0));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sky_text::departure(early, late, sky_text::kDepartureWays.x)[c], 0.3, 1e-6);
    EXPECT_NEAR(sky_text::departure(early, late, sky_text::kDepartureWays.y)[c], -0.2, 1e-6);
  }
}

}  // namespace
}  // namespace kasumi
