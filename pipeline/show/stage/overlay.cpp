#include "pipeline/show/stage/overlay.hpp"

#include <cmath>

#include "pipeline/show/stage/overlay_drawing.hpp"

namespace kasumi {

Overlay::Overlay(GlContext& context, const Installation& installation, const ModelBounds& bounds,
                 std::optional<std::filesystem::path> font_file)
    : context_(&context),
      shapes_(overlay_shapes(installation, bounds)),
      scene_width_(installation.scene.width),
      scene_height_(installation.scene.height),
      font_file_(std::move(font_file)) {}

Result<> Overlay::draw(const DrawTarget& target) {
  const auto place = fitted(target, scene_width_, scene_height_);
  const int width = static_cast<int>(place.width), height = static_cast<int>(place.height);
  if (width < 1 || height < 1) return {};
  if (!picture_ || picture_->width() != width || picture_->height() != height) {
    const auto drawn = draw_shapes(shapes_, width, height, place.width / scene_width_, font_file_);
    if (!drawn) return fail(drawn.error());
    auto picture = FlatPicture::create(*context_, *drawn);
    if (!picture) return fail(picture.error());
    picture_ = std::move(*picture);
  }
  return picture_->draw(target, place);
}

}  // namespace kasumi
