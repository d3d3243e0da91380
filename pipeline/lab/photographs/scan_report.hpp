// One sky scanner's table, answered as a photograph is.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/lab/photographs/sky_photograph.hpp"

namespace kasumi {

struct ScanReport {
  PhotographReport answer;  // without a picture
  std::string note;         // for people: what of the table was not used; empty: nothing
};

// The sun by `options`: its direction, or time and site. Errors: bad_input, of a table that is not as it should be. A
// sky that does not determine the air is no error.
Result<ScanReport> report_on_scan(const std::filesystem::path& file, const PhotographSetup& options);

}  // namespace kasumi
