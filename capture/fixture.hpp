// The fixture format: a recording of two cameras in a folder. docs/fixture-format.md describes it for strangers.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_table.hpp"
#include "base/result.hpp"
#include "capture/frame.hpp"

namespace kasumi {

constexpr int kFixtureFormat = 1;

// The head of fixture.toml.
struct FixtureInfo {
  std::string name;  // "clear-noon"
  std::string description;
  std::string licence;     // SPDX, like "CC0-1.0"
  std::string provenance;  // who made it, with what, seed
  Utc start_utc{};
};
// Problems are left in the table's file.
FixtureInfo read_fixture_info(const ConfigTable& root);

// One line of index.csv: one frame, or the instant a device went away.
struct IndexRow {
  int line = 0;               // in the file, from 1
  FrameMetadata metadata;     // status is good or flagged: the payload has not been looked at
  bool disconnected = false;  // of the metadata only captured_at and utc are valid then
  std::string payload;        // a file's name beside the index; empty for none
};

constexpr std::string_view kIndexHeader =
    "monotonic_ns,utc,sequence,fourcc,width,height,stride,bytes_used,exposure_s,gain,flags,payload";

// Reads camera_folder/index.csv and sees that the payloads exist. A last line without its line break is a row that was
// being written when the recording was cut, and is ignored. Errors (bad_input): everything that is wrong (the first 20
// problems), one per line with its line number.
Result<std::vector<IndexRow>> read_index(const std::filesystem::path& camera_folder);
// The line of a row, without line break.
std::string index_line(const IndexRow& row);

}  // namespace kasumi
