// A picture from outside, in whatever format its first byte says.
#include <string>

#include "pipeline/files/photograph_file.hpp"
#include "tests/fuzz/scratch.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kasumi;
  static const Scratch scratch;
  if (size == 0) return 0;
  std::string ending;
  switch (data[0]) {
    case 'p': ending = ".png"; break;
    case 't': ending = ".tiff"; break;
    case 'n': ending = ".ppm"; break;
    default: ending = ".jpg";
  }
  const auto photograph = read_photograph(scratch.file("picture" + ending, {data + 1, size - 1}));
  expect_value_or_sentence(photograph);
  if (photograph && photograph->encoded.empty()) std::abort();
  return 0;
}
