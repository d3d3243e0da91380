// The object's pixels in the order in which the processor mixes them, and where it needs the camera's light for a
// matte: what stays from one layer to the next.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "gles/composite/matte_nodes.hpp"
#include "gles/picture/wide_vectors.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// The object's layer as its texture holds it (layer.glsl).
struct LayerTexels {
  PixelBox box;
  double unit = 1.0;
  Image<glm::vec4> texels;
};

// Eight neighbours of a row.
struct EightPixels {
  int left = 0, top = 0;             // of the first in the picture, perhaps beyond its edges
  std::uint8_t edge = 0, whole = 0;  // a bit for each that the object covers in part; for each that it covers at all
  std::array<std::uint8_t, kLanes> free_share{}, confidence{};       // of the foreground's mask
  alignas(Floats) std::array<std::array<float, kLanes>, 4> texel{};  // red, green, blue, alpha
};

// Where the light that the camera sees is needed for the matte, and what its nodes are made from.
struct MatteBand {
  PixelBox box;  // of a plane of light; whole eights, and as far beyond the picture as neighbours are asked for
  struct Run {
    int left, right, y;  // whole eights of the picture's pixels
  };
  std::vector<Run> runs;  // of that plane, by rows
  struct Tap {
    std::uint32_t at;  // in the plane
    float weight;
  };
  std::vector<Tap> taps;
  struct Node {
    glm::ivec2 at;  // in the nodes' texture: what is in front lies in its right half
    std::uint32_t first_tap, last_tap;
  };
  std::vector<Node> nodes;  // with one tap at least
  glm::ivec2 corner_px{};   // as MatteNodes has them
  int cell_px = 0, columns = 0, rows = 0;
};

class MixedPixels {
 public:
  MixedPixels() = default;
  // `edges`, of which `covered` are not: rectangles of the picture. `foreground`: the free shares of its mask and their
  // confidence, of the picture's size; null: nothing is in front. `nodes`: of its matte; null: it is mixed as the mask
  // says.
  MixedPixels(const LayerTexels& layer, const std::vector<PixelBox>& edges, const std::vector<PixelBox>& covered,
              const Image<glm::u8vec2>* foreground, const MatteNodes* nodes);
  // Those with an edge's pixel, or all; by rows, those without one last.
  std::span<const EightPixels> eights(bool all) const { return {eights_.data(), all ? eights_.size() : edges_}; }
  double unit() const { return unit_; }
  bool is_left_open() const { return is_left_open_; }
  const MatteBand* band() const { return band_.nodes.empty() ? nullptr : &band_; }

 private:
  void find_band(const MatteNodes& nodes);

  std::vector<EightPixels> eights_;
  std::size_t edges_ = 0;
  MatteBand band_;
  double unit_ = 1.0;
  bool is_left_open_ = false;
};

}  // namespace kasumi
