// The sky of a picture in few elements, and where it grows brighter, which is the same whatever the tone curve is.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/units.hpp"
#include "calib/camera.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// One element of the picture that is neither clipped nor dark, nor next to one that is.
struct BrightnessSlope {
  float steepness = 0.0f;  // of ln light, 1/rad
  glm::vec2 place{};       // element
  glm::vec2 ahead{};       // uphill on the sphere, as a unit vector of the picture
};

// The picture shrunk, with what is known of its elements.
struct CoarseMaps {
  Image<glm::vec3> direction;   // world; zero where the lens does not reach
  Image<float> dimmest;         // ln light of the dimmest channel
  Image<std::uint8_t> open;     // above the horizon and not masked
  Image<std::uint8_t> clipped;  // open, and every channel is clipped somewhere in it
  std::vector<BrightnessSlope> slopes;
  double middle = 0.0;            // median of `dimmest`
  double clipped_elements = 0.0;  // how many are
  double shrink = 1.0;            // picture elements per element
  Radians resolution{};           // an element's size in the middle; 0: too small a picture, or none there

  // The element's centre in the picture.
  glm::dvec2 picture_element(const glm::dvec2& place) const { return shrink * (place + 0.5) - 0.5; }
};

// saturated: encoded level from which a channel is clipped.
CoarseMaps coarse_sky(const SkyPicture& picture, const Camera& camera, double saturated);

// Elements at which most slopes meet that point uphill to them, the best first.
std::vector<glm::vec2> where_slopes_meet(const CoarseMaps& sky, int most);

}  // namespace kasumi
