// A synthetic landscape to be seen through the air: a plain, foothills from 8 km, snowy ranges from 20 km. It is the
// same on every machine and in every run.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/units.hpp"
#include "gles/air/dome_land.hpp"

namespace kasumi {

// point: metres east and north of the observer. Metres above the sea.
double synthetic_height_m(const glm::dvec2& point, bool mountains = true);
// Linear sRGB reflectance: fields, woods, rock, snow. steepness: 0 level .. 1 upright.
glm::dvec3 synthetic_albedo(const glm::dvec2& point, double height_m, double steepness);

// The land between two azimuths as rings around the observer, finer where it is near.
struct LandView {
  Radians from, to;  // azimuths, clockwise; the whole circle when they are 2 pi apart
  int columns = 600;
  int rings = 420;
  double nearest_m = 1.0;
  double farthest_m = 160e3;
  bool mountains = true;  // else the bare plain
};
DomeLand make_synthetic_land(const LandView& view);

}  // namespace kasumi
