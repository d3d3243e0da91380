// The overlay as a picture: thin lines with dark edges, text on dark backgrounds, legible on snow and on forest.
#pragma once

#include <filesystem>
#include <optional>

#include "base/result.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/overlay_shapes.hpp"

namespace kasumi {

// Draws an antialiased polyline over the picture's contents. Pixel (0, 0) has its centre at the origin. A dark edge
// adds one more width on either side.
void draw_line(Image<Rgba8>& picture, const std::vector<glm::dvec2>& points, double width_px, const glm::dvec3& colour);

// `scale`: picture pixels per camera pixel. Without a font there are no labels. Errors: bad_input (font
// file unreadable).
Result<Image<Rgba8>> draw_shapes(const OverlayShapes& shapes, int width, int height, double scale,
                                 const std::optional<std::filesystem::path>& font_file);

}  // namespace kasumi
