#include "pipeline/landmarks.hpp"

#include <cmath>

#include "pipeline/placement.hpp"

namespace kasumi {

std::vector<Landmark> read_landmarks(const ConfigTable& root, const Site& site) {
  constexpr double kWithinSight_m = 400e3;  // Everest from the plains of Bengal; beyond, a number is wrong
  std::vector<Landmark> landmarks;
  for (const auto& table : root.tables("landmarks")) {
    if (table.has("distance_m") && !table.has("latitude_deg")) continue;  // for the visibility alone
    Landmark landmark;
    landmark.name = table.text("name");
    landmark.place_m =
        east_north_up(site, table.number("latitude_deg", {-90, 90}), table.number("longitude_deg", {-180, 180}),
                      table.number("altitude_m", {-500, 9000}));
    const double distance_m = std::hypot(landmark.place_m.x, landmark.place_m.y);
    const bool whole = table.has("latitude_deg") && table.has("longitude_deg");
    if (whole && distance_m > kWithinSight_m)
      table.problem("latitude_deg", fmt::format("a place within {:.0f} km of the site (it is {:.0f} km away)",
                                                kWithinSight_m / 1e3, distance_m / 1e3));
    landmark.place_m.z += lift_by_refraction(distance_m);
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

}  // namespace kasumi
