// The foreground mask, from one picture of the scene and a few strokes drawn by a person.
#pragma once

#include <filesystem>
#include <optional>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

enum class Stroke : std::uint8_t { none, hidden, free };

// A picture of strokes (PNG of the scene's size: red what stands in front, green or blue what is free, everything else
// not drawn upon), or a TOML file of lines:
//   [[hidden]] or [[free]]   points = [x1, y1, x2, y2, ...]   width_px = 5
// Errors (bad_input): every problem of it at once.
Result<Image<Stroke>> read_strokes(const std::filesystem::path& path, int width, int height);

struct SceneMask {
  Image<std::uint8_t> mask;   // 255 free, 0 hidden, between at soft edges
  double hidden_share = 0.0;  // of the picture, or of the box
};

struct MaskExtent {
  std::optional<glm::ivec4> box;  // x, y, width, height: only in it may anything be hidden
  double soft_px = 3.0;           // how far from the cut edge a pixel may be a mixture; 0: hard edges
};

// GrabCut from the strokes (nearby pixels of like colour join them), then the share of each edge pixel from the
// picture's own colours (guided filter, He et al. 2013). Areas that touch no stroke of their kind are dropped. Errors
// (bad_input): a kind of stroke is missing inside the box.
Result<SceneMask> find_scene_mask(const Image<Rgb8>& picture, const Image<Stroke>& strokes, const MaskExtent& options);

}  // namespace kasumi
