// A camera's JPEG.
#include "capture/frame.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

// The size the picture itself claims, so that the decoder is reached.
void read_size(std::span<const std::uint8_t> jpeg, int& width, int& height) {
  for (std::size_t i = 0; i + 8 < jpeg.size(); ++i) {
    if (jpeg[i] != 0xFF || (jpeg[i + 1] != 0xC0 && jpeg[i + 1] != 0xC1 && jpeg[i + 1] != 0xC2)) continue;
    height = jpeg[i + 5] * 256 + jpeg[i + 6];
    width = jpeg[i + 7] * 256 + jpeg[i + 8];
    return;
  }
}

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  Frame frame;
  frame.metadata.format = kMjpg;
  frame.metadata.width = frame.metadata.height = 16;
  read_size(input, frame.metadata.width, frame.metadata.height);
  if (std::int64_t{frame.metadata.width} * frame.metadata.height > 1 << 20) return;  // slow, and nothing new
  frame.metadata.bytes_used = static_cast<std::uint32_t>(input.size());
  frame.payload.bytes = input;
  const auto picture = decode(frame, YuvEncoding::bt601_full);
  expect_value_or_sentence(picture);
  if (picture) to_rgb(picture->view());
}
