#include "history/history_ring.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/files.hpp"

namespace kasumi {

namespace {

constexpr std::string_view kHead = "kasumi history 1: minutes, see kasumi history --help";

std::string head_line() {
  std::string line(kHead);
  line.resize(kHistoryLineBytes - 1, ' ');
  return line + '\n';
}

std::string empty_ring() {
  std::string text = head_line();
  const std::string blank = std::string(kHistoryLineBytes - 1, ' ') + '\n';
  text.reserve((kHistoryLines + 1) * kHistoryLineBytes);
  for (std::size_t i = 0; i < kHistoryLines; ++i) text += blank;
  return text;
}

bool is_ring(std::string_view text) {
  return text.size() == (kHistoryLines + 1) * kHistoryLineBytes && text.starts_with(head_line());
}

std::size_t place_of(std::uint32_t number) {
  return (1 + number % kHistoryLines) * kHistoryLineBytes;
}

}  // namespace

std::vector<HistoryLine> history_lines(std::string_view text) {
  std::vector<HistoryLine> lines;
  if (!is_ring(text)) return lines;
  for (std::size_t at = kHistoryLineBytes; at < text.size(); at += kHistoryLineBytes)
    if (auto line = parse_history(text.substr(at, kHistoryLineBytes)); line && place_of(line->number) == at)
      lines.push_back(*line);
  std::ranges::sort(lines, {}, &HistoryLine::number);
  return lines;
}

Result<std::vector<HistoryLine>> read_history(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::file_size(file, error) > 2 * kHistoryBytes && !error)
    return fail(FaultKind::bad_input, "{}: larger than a history can be", file.string());
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  if (!is_ring(*text)) return fail(FaultKind::bad_input, "{}: is no history of a kiosk", file.string());
  return history_lines(*text);
}

Result<HistoryRing> HistoryRing::open(const std::filesystem::path& file) {
  const auto text = read_text_file(file);
  std::uint32_t next = 1;
  if (text && is_ring(*text)) {
    const auto lines = history_lines(*text);
    if (!lines.empty()) next = lines.back().number + 1;
  } else if (auto made = write_text_file(file, empty_ring()); !made) {
    return fail(made.error());
  }
  UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (!fd) return fail(FaultKind::io, "{}: cannot be opened: {}", file.string(), std::strerror(errno));
  return HistoryRing(std::move(fd), file, next);
}

Result<> HistoryRing::append(HistoryLine line) {
  line.number = next_;
  const auto text = history_text(line);
  const bool placed = ::lseek(fd_.value(), static_cast<off_t>(place_of(next_)), SEEK_SET) >= 0;
  if (!placed || ::write(fd_.value(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      ::fdatasync(fd_.value()) != 0)
    return fail(FaultKind::io, "{}: a minute cannot be written: {}", file_.string(), std::strerror(errno));
  ++next_;
  return {};
}

}  // namespace kasumi
