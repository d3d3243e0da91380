// A part of an archive under way: records in order, one after the other, that outlive a kill and a power cut.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/result.hpp"
#include "base/unique_fd.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {

struct PartPlan {
  Archive archive;
  std::size_t first = 0, count = 0;  // pictures of it that belong into this part; first: from 0
};

class PartFile {
 public:
  // Makes the file, or with `resume` goes on behind the records that are there; what follows the last whole one is cut
  // off. BLOCKS as a disk does. Errors: bad_input (there are records and no `resume`, they are of another list, of
  // other options or of another part; another process writes the file), io.
  static Result<PartFile> open(const std::filesystem::path& path, const PartPlan& plan, bool resume);

  std::size_t done() const { return done_; }            // records that were there
  std::size_t mended_bytes() const { return mended_; }  // that were cut off
  // Writes a record at once, through to the disk after each block of them. Error: io.
  Result<> add(std::string_view line);
  // Writes the last block through. Error: io.
  Result<> finish();

 private:
  PartFile(std::filesystem::path path, UniqueFd file) : path_(std::move(path)), file_(std::move(file)) {}
  Result<> resume(const PartPlan& plan);

  std::filesystem::path path_;
  UniqueFd file_;
  std::size_t done_ = 0, mended_ = 0, unsynced_ = 0;
};

}  // namespace kasumi
