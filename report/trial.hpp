// Whether what is told arrives: a message of its own through each channel that is configured.
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

// BLOCKS until all have answered, two minutes at most. A sign of life is given only where the kiosk is well:
// whoever waits for it would believe it.
std::vector<Trial> try_channels(const ReportConfig& config, const Heard& heard, Clock& clock);

}  // namespace kasumi::report
