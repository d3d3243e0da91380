#include "estimator/sky/dome_table.hpp"

#include <bit>
#include <cstddef>

// Of dome_table.S.
extern "C" {
extern const std::int16_t kasumi_dome_table[];
extern const std::int32_t kasumi_dome_table_bytes;
}

namespace kasumi {
namespace {

static_assert(std::endian::native == std::endian::little, "dome_table.bin is used as it lies there");

class DomeNumbers {
 public:
  double one(double steps = 1.0) { return *next_++ / steps; }
  std::vector<double> some(double count, double steps) {
    std::vector<double> values;
    for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(one(steps));
    return values;
  }
  std::span<const std::int16_t> rest() const { return {next_, end_}; }

 private:
  const std::int16_t* next_ = kasumi_dome_table;
  const std::int16_t* end_ = next_ + static_cast<std::size_t>(kasumi_dome_table_bytes) / sizeof(std::int16_t);
};

DomeTable read_dome_table() {
  DomeNumbers numbers;
  DomeTable table;
  table.version = static_cast<int>(numbers.one());
  numbers.one();  // kinds: those of base/aerosol.hpp
  const double altitudes = numbers.one(), aods = numbers.one(), suns = numbers.one();
  table.ground_steepness = numbers.one(100.0);
  table.steepness_scale_m = numbers.one();
  table.altitudes_m = numbers.some(altitudes, 1.0);
  table.aods_550 = numbers.some(aods, 10000.0);
  table.sun_zeniths_deg = numbers.some(suns, 100.0);
  for (double& lobe : table.lobes) lobe = numbers.one(1000.0);
  table.rows = numbers.rest();
  return table;
}

}  // namespace

const DomeTable& dome_table() {
  static const DomeTable table = read_dome_table();
  return table;
}

}  // namespace kasumi
