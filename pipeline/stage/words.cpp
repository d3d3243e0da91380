#include "pipeline/stage/words.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/stage/caption.hpp"

namespace kasumi {

void Words::update(GlContext& context, const std::string& text, const std::optional<std::filesystem::path>& font_file,
                   const DrawTarget& target) {
  if (text_ == text && target_width_ == target.width) return;
  text_ = text;
  target_width_ = target.width;
  picture_.reset();
  if (text.empty()) return;
  CaptionStyle style;
  style.font_file = font_file;
  style.height_px = std::max(14.0, target.height / 28.0);
  style.largest_width_px = std::max(64, target.width * 8 / 10);
  const auto picture = draw_caption(text, style);
  if (!picture) {
    spdlog::warn("a message cannot be drawn: {}", picture.error().message);
    return;
  }
  if (auto flat = FlatPicture::create(context, *picture)) picture_ = std::move(*flat);
}

Result<> Words::draw(GlContext& context, const std::string& text, const std::optional<std::filesystem::path>& font_file,
                     bool at_top, double opacity, const DrawTarget& target) {
  update(context, text, font_file, target);
  if (!picture_ || opacity <= 0.0) return {};
  const double width = picture_->width(), height = picture_->height(), margin = target.height / 24.0;
  const FlatPlace place{(target.width - width) / 2.0, at_top ? margin : target.height - margin - height, width, height};
  return picture_->draw(target, place, opacity);
}

}  // namespace kasumi
