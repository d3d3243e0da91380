#include "pipeline/machine/progress.hpp"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace kasumi {

std::string progress_text(std::string_view title, std::size_t done, std::optional<std::size_t> total,
                          std::chrono::duration<double> elapsed) {
  constexpr std::size_t kWidth = 30;
  std::string text(title);
  if (total) {
    const std::size_t filled = *total > 0 ? std::min(kWidth, kWidth * done / *total) : kWidth;
    text += fmt::format(" [{:#<{}}{:.<{}}] {}/{}", "", filled, "", kWidth - filled, done, *total);
  } else {
    text += fmt::format(" {}", done);
  }
  if (done == 0 || !(elapsed.count() > 0.0)) return text;
  const double rate = static_cast<double>(done) / elapsed.count();
  text += fmt::format(", {:.{}f}/s", rate, rate < 1.0 ? 2 : 1);
  if (total && done < *total) {
    const auto left = static_cast<long>(static_cast<double>(*total - done) / rate + 0.5);
    text += left < 3600 ? fmt::format(", {}:{:02} left", left / 60, left % 60)
                        : fmt::format(", {}:{:02}:{:02} left", left / 3600, left / 60 % 60, left % 60);
  }
  return text;
}

Progress::Progress(std::string title, std::optional<std::size_t> total, std::optional<std::chrono::seconds> log_every)
    : title_(std::move(title)),
      total_(total),
      terminal_(::isatty(STDERR_FILENO) == 1),
      log_every_(log_every),
      started_(std::chrono::steady_clock::now()) {
  if (!terminal_) drawn_ = started_;
}

Progress::~Progress() {
  clear();
}

void Progress::advance(std::string_view detail) {
  ++done_;
  const auto now = std::chrono::steady_clock::now();
  if (terminal_ ? now - drawn_ < std::chrono::milliseconds(50) : !log_every_ || now - drawn_ < *log_every_) return;
  drawn_ = now;
  if (terminal_)
    draw(detail);
  else
    fmt::print(stderr, "kasumi: {}\n", progress_text(title_, done_, total_, now - started_));
}

void Progress::clear() {
  if (!terminal_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  drawn_ = {};
}

void Progress::draw(std::string_view detail) {
  const auto elapsed = std::chrono::steady_clock::now() - started_;
  fmt::print(stderr, "\r\033[K{}  {}", progress_text(title_, done_, total_, elapsed), detail);
  std::fflush(stderr);
}

}  // namespace kasumi
