// An archive on one page, self-contained: HTML 5 with SVG, no script, nothing fetched, and no time of making, so that
// the same records give the same bytes.
#pragma once

#include <string>

#include "pipeline/lab/archive/archive_figures.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {

std::string summary_page(const ArchiveFigures& figures, const Archive& archive);

}  // namespace kasumi
