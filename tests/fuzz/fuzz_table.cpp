// What researchers bring: 's' a sky scanner's table, 'h' the published data of Hosek and Wilkie's sky.
#include "estimator/sky/tensor_file.hpp"
#include "pipeline/photographs/sky_scan.hpp"
#include "tests/fuzz/scratch.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kasumi;
  static const Scratch scratch;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  if (data[0] == 's')
    expect_value_or_sentence(read_sky_scan(scratch.file("scan.csv", rest)));
  else
    expect_value_or_sentence(TensorFile::read(scratch.file("sky.tensor", rest)));
  return 0;
}
