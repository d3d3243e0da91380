// The arguments of `kasumi prove`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/site/files/picture_times.hpp"

namespace kasumi {

struct ProveRequest {
  std::vector<std::string> scenes;  // as `kasumi estimate` takes pictures
  PictureTimes times;
  std::string part;  // a landmark's name, or whatever `region` is to be called
  std::optional<double> distance_m, faces_deg;
  std::string landmarks;            // a file of them; empty: the air is that of `air`
  std::string air;                  // a table of it; empty: by the landmarks
  std::vector<double> region, sky;  // x, y, width, height in pixels; empty: the landmark's
  std::optional<double> lat, lon;   // empty: [site] of the landmarks' file
  std::string reference;            // the picture in which the regions were marked; empty: found
  std::string out, state;           // the second for `kasumi doctor`; empty: not written
};

}  // namespace kasumi
