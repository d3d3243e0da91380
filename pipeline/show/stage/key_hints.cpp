#include "pipeline/show/stage/key_hints.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/show/stage/font_patience.hpp"

namespace kasumi {

namespace {

constexpr double kSmallerHints[]{1.0, 0.85, 0.7, 0.6, 0.5, 0.4};  // tried in turn
constexpr int kMostHintLines = 3;                                 // six hints side by side keep their words whole so
constexpr double kLeastHint_px = 14.0;                            // smaller letters run together at 720 lines

// With letters in which all fit; the smallest where none do.
CaptionStyle fitting(const std::vector<std::string>& texts, CaptionStyle style, double usual_px) {
  style.most_lines = kMostHintLines;
  for (const double smaller : kSmallerHints) {
    style.height_px = std::max(kLeastHint_px, smaller * usual_px);
    const bool fits = std::ranges::all_of(texts, [&](const std::string& text) {
      const auto whole = with_fonts<Result<bool>>([text, style] { return caption_fits(text, style); });
      return whole && *whole && **whole;
    });
    if (fits) break;
  }
  return style;
}

}  // namespace

Result<> KeyHints::draw(GlContext& context, const std::vector<std::string>& texts, const MessageStyle& letters,
                        const DrawTarget& target) {
  if (texts.empty()) foot_ = 0.0;
  if (texts.empty()) return {};
  const double share = static_cast<double>(target.width) / static_cast<double>(texts.size());
  const double margin = target.height / 60.0;
  const CaptionKey key{letters.language, letters.print, target.width};
  if (texts_ != texts || key_ != key) {
    texts_ = texts;
    key_ = key;
    labels_.clear();
    auto style = label_style_of(letters, target.width, target.height);
    style.largest_width_px = std::max(64, static_cast<int>(0.94 * share));
    style = fitting(texts, style, style.height_px);
    double tallest = 0.0;
    for (const auto& text : texts) {
      auto flat = FlatPicture::create(context, picture_of_words(text, letters, style));
      if (!flat) return fail(flat.error());
      tallest = std::max(tallest, 1.0 * flat->height());
      labels_.push_back(std::move(*flat));
    }
    foot_ = std::ceil(tallest + 2.0 * margin);
  }
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    const double width = labels_[i].width(), height = labels_[i].height();
    const double left = std::round(share * (static_cast<double>(i) + 0.5) - width / 2.0);
    const double top = std::round(target.height - margin - height);
    if (auto drawn = labels_[i].draw(target, {left, top, width, height}); !drawn) return drawn;
  }
  return {};
}

}  // namespace kasumi
