// Tests whether reports arrive: a trial message through each configured channel.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "report/report_config.hpp"

namespace kasumi::report {

struct Trial {
  std::string channel;       // as its table in report.toml
  Result<std::string> came;  // in words; errors: why it did not
};

// BLOCKS until all have answered, two minutes at most. A sign of life is sent only if the kiosk is well, since its
// receiver would take it for real.
std::vector<Trial> try_channels(const ReportConfig& config, const Heard& heard, Clock& clock);

}  // namespace kasumi::report
