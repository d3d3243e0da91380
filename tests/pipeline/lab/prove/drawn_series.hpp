// Pictures of towers under air of known extinction, hour by hour over some days, as files; drawn here by M Eq 12 alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace kasumi {

struct DrawnPicture {
  std::string name, utc;
  glm::dvec3 per_m{0.0};
  int moved_px = 0;  // the whole view, to the right
  bool night = false, drops = false;
};

struct DrawnSeries {
  std::filesystem::path folder;
  std::filesystem::path list, landmarks, air;  // with times and kinds of air; of the towers; the known extinction
  std::vector<DrawnPicture> pictures;
};

// Eight days of five hours. One day's view has moved by 9 pixels; one picture is of the night, one has drops on its lens.
DrawnSeries draw_series(const std::filesystem::path& folder);

}  // namespace kasumi
