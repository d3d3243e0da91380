#include "pipeline/log_lines.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kasumi {
namespace {

constexpr int kErrorPriority = 3;

int priority_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical: return 2;
    case spdlog::level::err: return kErrorPriority;
    case spdlog::level::warn: return 4;
    case spdlog::level::info: return 6;
    default: return 7;
  }
}

// The journal takes every line for an entry of its own.
void append_with_priority(std::string_view text, int priority, std::string& out) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  for (std::size_t from = 0; from <= text.size();) {
    const auto to = std::min(text.find('\n', from), text.size());
    out += fmt::format("<{}>{}\n", priority, text.substr(from, to - from));
    from = to + 1;
  }
}

class JournalFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const auto level = spdlog::level::to_string_view(message.level);
    std::string lines;
    append_with_priority(fmt::format("kasumi: {}: {}", std::string_view(level.data(), level.size()),
                                     std::string_view(message.payload.data(), message.payload.size())),
                         priority_of(message.level), lines);
    out.append(lines.data(), lines.data() + lines.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JournalFormatter>(); }
};

}  // namespace

bool stderr_is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  return stream && ::fstat(STDERR_FILENO, &status) == 0 &&
         stream ==
             fmt::format("{}:{}", static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino));
}

void log_to_stderr() {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("kasumi", std::make_shared<spdlog::sinks::ansicolor_stderr_sink_mt>()));
  spdlog::set_pattern("kasumi: %^%l%$: %v");
  if (stderr_is_journal()) spdlog::set_formatter(journal_formatter());
}

std::unique_ptr<spdlog::formatter> journal_formatter() {
  return std::make_unique<JournalFormatter>();
}

void print_error(std::string_view text) {
  auto line = fmt::format("kasumi: {}\n", text);
  if (stderr_is_journal()) {
    std::string lines;
    append_with_priority(line, kErrorPriority, lines);
    line = std::move(lines);
  }
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace kasumi
