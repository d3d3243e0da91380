// Sky and land computed on the CPU, pixel by pixel in double precision: the reference for the GPU, and the source of
// HDR files.
#pragma once

#include <optional>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/sky/dome_scene.hpp"
#include "gles/air/dome_land.hpp"

namespace kasumi {

// Intersection of a line of sight with the land.
struct LandHit {
  glm::dvec3 place{0.0};  // metres; x east, y north, z up from the sea below the observer
  double altitude_m = 0.0;
  glm::dvec3 normal{0.0, 0.0, 1.0};
  glm::dvec3 albedo{0.2};
};
// Land whose columns go from azimuth `from` to `to`, seen from above its middle.
class LandRayCaster {
 public:
  LandRayCaster(const DomeLand& land, Radians from, Radians to) : land_(land), from_(from), to_(to) {}
  std::optional<LandHit> along(const Direction& view, double observer_m) const;

 private:
  const DomeLand& land_;
  Radians from_, to_;
};

// Linear sRGB, cd/m2; black beyond a fisheye's circle. land: null for none.
Image<glm::vec3> sky_light_picture(const PanoramaView& view, const DomeScene& scene, const LandRayCaster* land);
// Encoded as on the GPU, but rounded instead of dithered.
Image<Rgb8> sky_shown_picture(const PanoramaView& view, const DomeScene& scene, const LandRayCaster* land);

// Light of one pixel without the sun's disc, as in sky_light_picture().
glm::dvec3 sky_light_at(const PanoramaView& view, const DomePainter& painter, double observer_m,
                        const LandRayCaster* land, const glm::dvec2& pixel);
// Encoded colour of one pixel, 0 .. 1.
glm::dvec3 sky_shown_at(const PanoramaView& view, const DomePainter& painter, double observer_m,
                        const LandRayCaster* land, const glm::dvec2& pixel);

}  // namespace kasumi
