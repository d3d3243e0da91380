// How a camera draws an edge: its blur and its sharpening, from straight edges between two even areas in a picture of
// a still scene (the slanted edge of ISO 12233, fitted as a model instead of differentiated).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/jpeg_steps.hpp"
#include "base/units.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

// A step in linear light, blurred by a Gaussian of point_spread_px and the pixel's square, encoded by the response,
// then sharpened: Y + sharpening (Y - its binomial mean over 3 x 3 pixels).
struct DrawnEdge {
  glm::dvec2 pixel{};
  Radians normal{};  // clockwise from the picture's x axis, towards the bright side
  double point_spread_px = 0.0;
  double sharpening = 0.0;
  double step = 0.0;      // encoded, bright minus dark, 0..1
  double residual = 0.0;  // rms of encoded values, over the step
  glm::ivec2 window{};    // its middle
  std::array<double, 8> fitted{};
};

// `luma`: encoded Y, 0..1; best the mean of several pictures. `box`: left, top, right, bottom; empty: everywhere. At
// most one edge in each cell of 20 x 20 pixels; those that the model does not fit within 5 % of their step, or that are
// clipped, are left out.
std::vector<DrawnEdge> find_drawn_edges(const Image<float>& luma, const Response& response,
                                        const std::optional<glm::ivec4>& box = {});

struct DrawnSharpness {
  double point_spread_px = 0.0, point_spread_sigma_px = 0.0;
  double sharpening = 0.0, sharpening_sigma = 0.0;
  int edges = 0;  // that it was taken from
};
// Of the edges that are drawn as narrow as the narrowest fifth, within a tenth, weighted by how well each is known:
// things have soft edges of their own, and none is drawn sharper than the camera can. `jpeg`: what the picture was
// rounded to, or null. Rounding makes an edge look wider and sharpened; so the same edges are drawn by the model, rounded
// in the same blocks and fitted again, with such numbers that what is found is what was found in the picture. Empty:
// fewer than 5 of them.
std::optional<DrawnSharpness> sharpness_of(std::span<const DrawnEdge> edges, const Response& response,
                                           const JpegSteps* jpeg);

}  // namespace kasumi
