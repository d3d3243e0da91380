#include "pipeline/show/stage/caption.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/show/stage/text_layout.hpp"
#include "pipeline/show/stage/text_plate.hpp"

namespace kasumi {
namespace {

// Below, letters are no shapes; above, higher than a line on any display.
constexpr double kMinHeight = 6.0, kMostHeight = 512.0;
constexpr int kMostWidth = 16384;  // of any GPU's textures
constexpr int kMostLines = 200;    // bounds time and memory, whatever a configuration says

constexpr double kBackgroundOpacity = 0.72;  // the picture behind is still seen

// Around the text.
struct Margins {
  double side, above;
  explicit Margins(double em_px) : side(0.6 * em_px), above(0.35 * em_px) {}
};

Result<TextLayout> laid_out(const std::string& text, const CaptionStyle& style) {
  Problems problems;
  if (!(style.height_px >= kMinHeight && style.height_px <= kMostHeight))
    problems.add("caption: lines of {} pixels: expected {} to {}", style.height_px, kMinHeight, kMostHeight);
  if (style.largest_width_px < 1 || style.largest_width_px > kMostWidth)
    problems.add("caption: {} pixels wide: expected 1 to {}", style.largest_width_px, kMostWidth);
  if (style.most_lines < 1 || style.most_lines > kMostLines)
    problems.add("caption: {} lines: expected 1 to {}", style.most_lines, kMostLines);
  if (text.size() > kMostCaptionBytes)
    problems.add("caption: {} bytes: expected {} at most", text.size(), kMostCaptionBytes);
  if (!problems.empty()) return fail(problems.fault());
  const Margins margins(style.height_px / kLineOverEm);
  return TextLayout::of(text, {style.font_file, style.language, style.height_px,
                               std::max(style.largest_width_px - 2.0 * margins.side, 1.0), style.most_lines});
}

}  // namespace

Result<Image<Rgba8>> draw_caption(const std::string& text, const CaptionStyle& style) {
  const auto layout = laid_out(text, style);
  if (!layout) return fail(layout.error());
  const Margins margins(layout->em_px());
  // A font may claim glyphs of any size: what does not fit is cut.
  const int width = static_cast<int>(
      std::ceil(std::min(layout->width() + 2.0 * margins.side, static_cast<double>(style.largest_width_px))));
  const int height = static_cast<int>(std::ceil(layout->height() + 2.0 * margins.above));
  const auto coverage = layout->draw(width, height, margins.above);
  if (!coverage) return fail(coverage.error());
  return text_plate(*coverage, kBackgroundOpacity, 0.45 * layout->em_px());
}

Result<bool> caption_fits(const std::string& text, const CaptionStyle& style) {
  const auto layout = laid_out(text, style);
  if (!layout) return fail(layout.error());
  return layout->left_out() == 0 && !layout->cuts_words();
}

Result<std::vector<std::string>> caption_faults(const std::string& text, const CaptionStyle& style) {
  const auto layout = laid_out(text, style);
  if (!layout) return fail(layout.error());
  std::vector<std::string> faults;
  for (const auto& word : layout->missing())
    faults.push_back(
        fmt::format("no installed font can show \"{}\"{}", word.text,
                    word.package.empty() ? std::string() : fmt::format(" (on Debian: apt install {})", word.package)));
  if (layout->left_out() > 0)
    faults.push_back(fmt::format("{} lines more than the {} that are shown", layout->left_out(), style.most_lines));
  return faults;
}

}  // namespace kasumi
