// Writes one camera's recording so that what is on the disk replays after a cut at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>

#include "base/result.hpp"
#include "base/unique_fd.hpp"
#include "capture/fixture.hpp"
#include "capture/frame.hpp"

namespace kasumi {

struct FixtureWriterOptions {
  bool share_equal_payloads = true;  // rows with the same bytes name one file
};

class FixtureWriter {
 public:
  // Creates the folder and its index. Error (bad_input): the folder has an index already; recordings are not
  // overwritten.
  static Result<FixtureWriter> create(const std::filesystem::path& camera_folder, FixtureWriterOptions options = {});

  // The payload first (bytes_used of it; fewer make a truncated frame), its row when the payload is whole on the disk.
  // Status flagged becomes the flag `error`; truncated follows from the bytes. Errors: bad_input (impossible
  // geometry; nothing is written), io.
  Result<> append(const Frame& frame);
  Result<> append_disconnect(Instant at, Utc utc);
  int row_count() const { return row_count_; }
  std::uint64_t bytes_written() const { return bytes_written_; }  // of payloads and rows

 private:
  FixtureWriter(std::filesystem::path folder, UniqueFd index, FixtureWriterOptions options)
      : folder_(std::move(folder)), index_(std::move(index)), options_(options) {}
  Result<std::string> store(const Frame& frame);
  Result<> append_row(const IndexRow& row);

  std::filesystem::path folder_;
  UniqueFd index_;
  FixtureWriterOptions options_;
  int row_count_ = 0;
  int payload_count_ = 0;
  std::uint64_t bytes_written_ = 0;
  std::unordered_map<std::uint64_t, std::string> names_;  // of payloads by their hash
};

}  // namespace kasumi
