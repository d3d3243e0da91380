#include "pipeline/show/stage/key_hints.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

Result<> KeyHints::draw(GlContext& context, const std::vector<std::string>& texts, const MessageOptions& letters,
                        const DrawTarget& target) {
  if (texts.empty()) return {};
  const double share = static_cast<double>(target.width) / static_cast<double>(texts.size());
  const CaptionKey key{letters.language, letters.print, target.width};
  if (texts_ != texts || key_ != key) {
    texts_ = texts;
    key_ = key;
    labels_.clear();
    auto style = style_of(letters, target.width, target.height);
    style.largest_width_px = std::max(64, static_cast<int>(0.94 * share));
    for (const auto& text : texts) {
      auto flat = FlatPicture::create(context, picture_of_words(text, letters, style));
      if (!flat) return fail(flat.error());
      labels_.push_back(std::move(*flat));
    }
  }
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    const double width = labels_[i].width(), height = labels_[i].height();
    const double left = std::round(share * (static_cast<double>(i) + 0.5) - width / 2.0);
    const double top = std::round(target.height - target.height / 60.0 - height);
    if (auto drawn = labels_[i].draw(target, {left, top, width, height}); !drawn) return drawn;
  }
  return {};
}

}  // namespace kasumi
