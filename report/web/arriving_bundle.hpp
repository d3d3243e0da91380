// A bundle that arrives in pieces, over hours, restarts and power cuts:
//
//     FOLDER/arriving.part            what has come of it
//     FOLDER/arriving.txt             which one it is, and how much of it is surely on the disk
//     FOLDER/content/fetched.kasumi   the last that came whole
//     FOLDER/fetched.txt              which one that is
//
// Whose it is, and whether it is whole, is for `kasumi content` to find out: here it is bytes.
#pragma once

#include <filesystem>
#include <span>

#include "base/lasting_file.hpp"
#include "base/result.hpp"
#include "base/unique_fd.hpp"
#include "report/web/pull_answer.hpp"

namespace kasumi::report {

class ArrivingBundle {
 public:
  // At most so many bytes are fetched again after a power cut.
  static constexpr std::uint64_t kSync = std::uint64_t{8} << 20;

  // Of this address; what was kept of another one is forgotten. `left_free`: bytes of the disk that are not for it.
  ArrivingBundle(std::filesystem::path folder, const std::string& url, std::uint64_t left_free,
                 std::uint64_t sync = kSync, FreeBytes free_bytes = free_bytes_of);

  const std::string& whole_tag() const { return whole_.tag; }  // of the last that came whole; empty: none is here
  const std::string& tag() const { return part_.tag; }         // of the one that is under way; empty: none is
  std::uint64_t bytes() const { return bytes_; }               // that are here of it

  // From its beginning; it will have `all` bytes, 0: unknown. Error: io (the disk is too full).
  Result<> begin(std::string tag, std::uint64_t all);
  // Where it was left. Error: io (the same).
  Result<> resume(std::uint64_t all);
  // BLOCKS for the disk now and then. Error: io (the same).
  Result<> add(std::span<const char> piece);
  // What has come is kept over a power cut. Best effort.
  void keep();
  // It is whole. On return it is on the disk, under its name. Error: io.
  Result<> finish();
  void forget();

 private:
  Result<> fits(std::uint64_t more) const;
  Result<> write_through();

  std::filesystem::path folder_;
  std::uint64_t left_free_, sync_;
  FreeBytes free_bytes_;
  PullNote whole_, part_;  // of the disk
  UniqueFd file_;
  std::uint64_t bytes_ = 0;
};

}  // namespace kasumi::report
