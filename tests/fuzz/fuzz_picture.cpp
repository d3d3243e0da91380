// A picture from outside, in whatever format its first byte says.
#include <string>

#include "pipeline/site/files/photograph_file.hpp"
#include "tests/fuzz/scratch.hpp"
#include "tests/fuzz/small_picture.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  if (is_large_picture(rest)) return;
  std::string ending;
  switch (input[0]) {
    case 'p': ending = ".png"; break;
    case 't': ending = ".tiff"; break;
    case 'n': ending = ".ppm"; break;
    default: ending = ".jpg";
  }
  const auto photograph = read_photograph(scratch.file("picture" + ending, rest));
  expect_value_or_sentence(photograph);
  if (photograph && photograph->encoded.empty()) std::abort();
}
