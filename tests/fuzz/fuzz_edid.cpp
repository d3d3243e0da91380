// What a display says of itself.
#include <numeric>
#include <vector>

#include "gles/display/kms_edid.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  std::vector<std::uint8_t> edid(input.begin(), input.end());
  // Its checksum put right, so that what lies behind it is reached.
  if (edid.size() >= 128 && edid[127] % 2 == 0)
    edid[127] = static_cast<std::uint8_t>(-std::accumulate(edid.begin(), edid.begin() + 127, 0));
  const std::string name = kasumi::edid_name(edid);
  // It goes into logs and status: nothing but what can be printed.
  for (const char c : name)
    if (c < ' ' || c > '~') std::abort();
  kasumi::edid_identity(edid);
}
