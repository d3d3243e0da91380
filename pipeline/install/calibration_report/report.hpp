// A calibration file for people to read: each camera's steps with their numbers, uncertainties and expected values, and
// what is still to be done, as one self-contained page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/install/calibration_report/expectations.hpp"

namespace kasumi {

struct ReportRow {
  std::string label, value, sigma;  // texts with units; empty: none
  std::string should_be, remedy;
  std::optional<Verdict> verdict;
};

struct ReportStep {
  std::string title, utc, from;
  std::vector<ReportRow> rows;
  std::vector<std::string> remarks;
  std::string picture_name;           // empty: the step drew nothing
  std::vector<std::uint8_t> picture;  // PNG; empty: it is not there any more
};

struct ReportSection {
  std::string name, description;  // "sky"; "1032 x 778 pixels, serial FE-1"
  std::vector<ReportStep> steps;
  std::vector<RequiredStep> missing;
};

struct CalibrationReport {
  std::string name, site;
  std::vector<ReportSection> cameras;  // sky, scene
  std::string file;                    // the text of it all
};

// Errors: bad_input (no calibration file, or values that cannot be read: all of them at once), io.
Result<CalibrationReport> read_calibration_report(const std::filesystem::path& calibration);

// HTML 5, UTF-8, with its pictures inside; no script, nothing fetched. `made_utc`: ISO 8601.
std::string html_of(const CalibrationReport& report, const std::string& made_utc);

}  // namespace kasumi
