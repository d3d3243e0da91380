// An archive on one page, self-contained: HTML 5 with SVG, no script, nothing fetched, and no time of making, so that
// the same records give the same bytes.
#pragma once

#include <string>

#include "pipeline/lab/archive/archive_figures.hpp"
#include "pipeline/lab/archive/archive_record.hpp"
#include "pipeline/lab/archive/photometer.hpp"
#include "pipeline/lab/archive/series_figures.hpp"

namespace kasumi {

struct ArchiveSummary {
  const ArchiveFigures& figures;
  const SeriesFigures& series;
  const PhotometerComparison* photometer;  // null: none was given
  const Archive& archive;
};
std::string summary_page(const ArchiveSummary& summary);

// The same figures as one JSON object, for programs.
std::string summary_json(const ArchiveSummary& summary);

// Sections of the page.
std::string series_sections(const ArchiveSummary& summary);

}  // namespace kasumi
