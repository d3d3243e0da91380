// Draws the overlay over the finished picture, for people who set up a kiosk.
#pragma once

#include <optional>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/overlay_shapes.hpp"

namespace kasumi {

// Belongs to the thread of its GL context.
class Overlay {
 public:
  // `font_file`: as CaptionStyle's.
  Overlay(GlContext& context, const Installation& installation, const ModelBounds& bounds,
          std::optional<std::filesystem::path> font_file);
  // Rendered again only for a target of another size. Errors: bad_input (font file), device.
  Result<> draw(const DrawTarget& target);

 private:
  GlContext* context_;
  OverlayShapes shapes_;
  int scene_width_;
  int scene_height_;
  std::optional<std::filesystem::path> font_file_;
  std::optional<FlatPicture> picture_;
};

}  // namespace kasumi
