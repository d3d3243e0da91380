// What curators write, and the fonts they bring: 't' a text, 'f' a font file.
#include "pipeline/stage/caption.hpp"
#include "tests/fuzz/scratch.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kasumi;
  static const Scratch scratch;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  CaptionStyle style{.font_file = std::nullopt, .height_px = 12.0, .largest_width_px = 160};
  std::string text = "Kasumi \u971e\n3.5 km";
  if (data[0] == 'f')
    style.font_file = scratch.file("font.ttf", rest);
  else
    text.assign(rest.begin(), rest.end());
  const auto picture = draw_caption(text, style);
  expect_value_or_sentence(picture);
  return 0;
}
