// The lines of a part, one at a time; a line is bounded, since the file may be anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace kasumi {

class RecordLines {
 public:
  explicit RecordLines(const std::filesystem::path& path);
  bool opened() const { return file_.is_open(); }
  // false: at the end, or a line is longer than any record.
  bool next();
  std::string_view line() const { return line_; }  // without its newline
  std::uint64_t begin() const { return begin_; }   // where it is in the file
  std::uint64_t end() const { return end_; }       // behind its newline
  bool whole() const { return whole_; }            // it has a newline
  bool too_long() const { return too_long_; }
  // The next line is the one that begins there.
  void go_to(std::uint64_t begin);

 private:
  std::ifstream file_;
  std::string buffer_;
  std::string_view line_;
  std::uint64_t begin_ = 0, end_ = 0;
  bool whole_ = false, too_long_ = false;
};

}  // namespace kasumi
