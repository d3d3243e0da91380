// The overlay as a picture: thin lines with dark edges, words on dark grounds, to be read on snow and on forest.
#pragma once

#include <filesystem>
#include <optional>

#include "base/result.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/stage/overlay_shapes.hpp"

namespace kasumi {

// A line of that width along the points, smooth, over what the picture holds. Pixels: (0, 0) is the centre of the top
// left one. Its dark edge is one more width wide on either side.
void draw_line(Image<Rgba8>& picture, const std::vector<glm::dvec2>& points, double width_px, const glm::dvec3& colour);

// `scale`: pixels of the picture for one of the camera's. Without a font there are no words. Errors: bad_input (font
// file unreadable).
Result<Image<Rgba8>> draw_shapes(const OverlayShapes& shapes, int width, int height, double scale,
                                 const std::optional<std::filesystem::path>& font_file);

}  // namespace kasumi
