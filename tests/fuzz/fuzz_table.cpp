// What researchers bring: 's' a sky scanner's table, 'h' the published data of Hosek and Wilkie's sky.
#include "estimator/sky/tensor_file.hpp"
#include "pipeline/lab/photographs/scan_readings.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  if (input[0] == 's')
    expect_value_or_sentence(read_scan_readings(scratch.file("scan.csv", rest)));
  else
    expect_value_or_sentence(TensorFile::read(scratch.file("sky.tensor", rest)));
}
