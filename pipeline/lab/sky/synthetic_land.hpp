// A synthetic landscape to be seen through the air: a plain of fields and woods with low hills from 3 km, or foothills
// from 8 km and snowy ranges from 20 km behind it. It is the same on every machine and in every run.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/units.hpp"
#include "gles/air/dome_land.hpp"

namespace kasumi {

// point: metres east and north of the observer. footprint_m: what is smaller is not resolved there. Metres above the sea,
// of treetops where there are woods.
double synthetic_height_m(const glm::dvec2& point, bool mountains = true, double footprint_m = 0.0);
// Linear sRGB reflectance: fields, woods, rock, snow. steepness: 0 level .. 1 upright.
glm::dvec3 synthetic_albedo(const glm::dvec2& point, double height_m, double steepness, double footprint_m = 0.0);

// The land between two azimuths as rings around the observer, one for each row of the picture and more in the distance.
struct LandView {
  Radians from, to;  // azimuths, clockwise; the whole circle when they are 2 pi apart
  int columns = 600;
  Radians steepest = from_degrees(90.0);  // how far below the horizon it is seen
  Radians row = from_degrees(0.1);        // a row of the picture
  double eyes_m = 25.0;                   // above the plain
  int rings = 420;                        // those in the distance
  double nearest_m = 1.0;
  double farthest_m = 160e3;
  bool mountains = true;  // else the plain
};
DomeLand make_synthetic_land(const LandView& view);

}  // namespace kasumi
