// A week of minutes in a file of 1 MB that never grows: line after line, then over the oldest.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "base/unique_fd.hpp"
#include "history/history_line.hpp"

namespace kasumi {

constexpr std::size_t kHistoryBytes = 1 << 20;
constexpr std::size_t kHistoryLines =
    kHistoryBytes / kHistoryLineBytes - 1;                // 10081: a week and a minute; the first is the head
constexpr std::string_view kHistoryFile = "history.txt";  // in the state's folder

class HistoryRing {
 public:
  // Goes on after the newest whole line of the file; makes it where it is missing or something else. Errors: io.
  static Result<HistoryRing> open(const std::filesystem::path& file);
  // Gives the line its number and writes it through to the disk: one block of it, and nothing else, so that flash memory
  // wears by 6 MB a day. A power cut at any moment loses this line at most. BLOCKS for as long as the disk takes.
  // Errors: io.
  Result<> append(HistoryLine line);

 private:
  HistoryRing(UniqueFd fd, std::filesystem::path file, std::uint32_t next)
      : fd_(std::move(fd)), file_(std::move(file)), next_(next) {}
  UniqueFd fd_;
  std::filesystem::path file_;
  std::uint32_t next_;
};

// The whole lines of such a file's text, oldest first. Whatever else it holds is left out.
std::vector<HistoryLine> history_lines(std::string_view text);
// Errors: bad_input (no such file, or far too large), io.
Result<std::vector<HistoryLine>> read_history(const std::filesystem::path& file);

}  // namespace kasumi
