#include "pipeline/show/stage/words.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/show/stage/font_patience.hpp"
#include "pipeline/show/stage/plain_letters.hpp"

namespace kasumi {

CaptionStyle style_of(const MessageStyle& options, int width, int height) {
  CaptionStyle style;
  style.font_file = options.font_file;
  style.language = code_of(options.language);
  style.height_px = std::max(14.0, height / 28.0) * options.print;
  style.largest_width_px = std::max(64, width * 8 / 10);
  return style;
}

CaptionStyle label_style_of(const MessageStyle& options, int width, int height) {
  return style_of(options, width, std::min(width, height));
}

Image<Rgba8> picture_of_words(const std::string& text, const MessageStyle& options, const CaptionStyle& style) {
  if (!options.plain_letters) {
    auto picture = with_fonts<Result<Image<Rgba8>>>([text, style] {
                     return draw_caption(text, style);
                   }).value_or(fail(FaultKind::io, "the fonts' disk does not answer, or no thread is left to ask it"));
    if (picture) return std::move(*picture);
    spdlog::warn("a message is drawn in plain letters: {}", picture.error().message);
  }
  return draw_plain_letters(text, style.height_px, style.largest_width_px);
}

void Words::update(GlContext& context, const std::string& text, const MessageStyle& options, const DrawTarget& target) {
  const CaptionKey key{options.language, options.print, target.width};
  const bool may_improve = waits_for_fonts_ && hung_fonts == 0;
  if (text_ == text && key_ == key && !may_improve) return;
  waits_for_fonts_ = false;
  text_ = text;
  key_ = key;
  picture_.reset();
  if (text.empty()) return;
  const auto style = style_of(options, target.width, target.height);
  if (auto flat = FlatPicture::create(context, picture_of_words(text, options, style))) picture_ = std::move(*flat);
  waits_for_fonts_ = !options.plain_letters && hung_fonts > 0;
}

Result<> Words::draw(GlContext& context, const std::string& text, const MessageStyle& options, bool at_top,
                     double opacity, const DrawTarget& target) {
  update(context, text, options, target);
  if (!picture_ || opacity <= 0.0) return {};
  const double width = picture_->width(), height = picture_->height(), margin = target.height / 24.0;
  const FlatPlace place{(target.width - width) / 2.0, at_top ? margin : target.height - margin - height, width, height};
  return picture_->draw(target, place, opacity);
}

}  // namespace kasumi
