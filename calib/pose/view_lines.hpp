// What is kept of a view to recognise it by: where its lines are and how strong, and nothing of its brightness.
#pragma once

#include <cstdint>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "calib/lens/lens.hpp"

namespace kasumi {

// A camera's picture in linear light, shrunk by a whole factor (each element the mean of its pixels).
struct ShrunkView {
  Image<float> light;
  int factor = 1;
  Image<std::uint8_t> usable;  // 0: ignored (outside the image circle, open sky); empty: all usable
};

// The pixel of the camera's picture at an element of a view shrunk by `factor`.
inline glm::dvec2 unshrunk(double x, double y, int factor) {
  return (glm::dvec2{x, y} + 0.5) * double(factor) - 0.5;
}

// A picture and its negative leave the same lines, so no picture can be made of them again.
struct ViewLines {
  static constexpr int kStrongest = 35;
  Image<std::uint8_t> strength;  // 0 (even) to kStrongest, of the shrunk picture's size
  int factor = 1;
  Image<std::uint8_t> usable;  // as above
};

// Steepness of the picture relative to the contrast around, so that weather, light and exposure matter little.
ViewLines lines_of(const Lens& lens, const ShrunkView& view);

// Where the lens sees something, 1 or 0: the rim of an image circle stays where it is whatever the camera does.
Image<float> seen_by(const Lens& lens, int width, int height, int factor);

}  // namespace kasumi
