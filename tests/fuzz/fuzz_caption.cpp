// What curators write, and the fonts they bring: 't' a text, 'f' a font file.
#include <algorithm>
#include <iterator>

#include "pipeline/show/stage/caption.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

constexpr std::ptrdiff_t kLongestText = 100;  // bytes: more lines only take longer

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  CaptionStyle style{.font_file = std::nullopt, .height_px = 12.0, .largest_width_px = 160};
  std::string text = "Kasumi \u971e\n3.5 km";
  if (input[0] == 'f')
    style.font_file = scratch.file("font.ttf", rest);
  else
    text.assign(rest.begin(), rest.begin() + std::min<std::ptrdiff_t>(std::ssize(rest), kLongestText));
  const auto picture = draw_caption(text, style);
  expect_value_or_sentence(picture);
}
