#include "pipeline/log_lines.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kasumi {
namespace {

constexpr int kErrorPriority = 3, kInfoPriority = 6;

int priority_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical: return 2;
    case spdlog::level::err: return kErrorPriority;
    case spdlog::level::warn: return 4;
    case spdlog::level::info: return kInfoPriority;
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

bool is_journal(int descriptor) {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  return stream && ::fstat(descriptor, &status) == 0 &&
         stream ==
             fmt::format("{}:{}", static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino));
}

std::atomic<bool> may_wait = true;

// Without waiting for whoever reads it.
bool takes_a_line(int descriptor) {
  pollfd wanted{descriptor, POLLOUT, 0};
  return may_wait || (::poll(&wanted, 1, 0) == 1 && (wanted.revents & POLLOUT) != 0);
}

class UnhinderedStderr final : public spdlog::sinks::ansicolor_stderr_sink_mt {
  using Stderr = spdlog::sinks::ansicolor_stderr_sink_mt;

 public:
  void log(const spdlog::details::log_msg& message) override {
    if (!takes_a_line(STDERR_FILENO)) {
      ++lost_;
      return;
    }
    if (const auto lost = lost_.exchange(0); lost > 0)
      Stderr::log({"kasumi", spdlog::level::warn, fmt::format("log: {} lines were lost", lost)});
    Stderr::log(message);
  }

 private:
  std::atomic<int> lost_ = 0;
};

void print(std::string_view text, std::FILE* to, bool journal, int priority) {
  if (!takes_a_line(::fileno(to))) return;
  std::string lines(text);
  if (journal) {
    lines.clear();
    append_with_priority(text, priority, lines);
  }
  std::fwrite(lines.data(), 1, lines.size(), to);
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
  return is_journal(STDERR_FILENO);
}

bool stdout_is_journal() {
  return is_journal(STDOUT_FILENO);
}

void log_to_stderr() {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("kasumi", std::make_shared<UnhinderedStderr>()));
  spdlog::set_pattern("kasumi: %^%l%$: %v");
  if (stderr_is_journal()) spdlog::set_formatter(journal_formatter());
}

void never_wait_for_log() {
  may_wait = false;
  std::signal(SIGPIPE, SIG_IGN);
}

std::unique_ptr<spdlog::formatter> journal_formatter() {
  return std::make_unique<JournalFormatter>();
}

void print_error(std::string_view text) {
  print_refusal(fmt::format("kasumi: {}\n", text));
}

void print_refusal(std::string_view text) {
  print(text, stderr, stderr_is_journal(), kErrorPriority);
}

void print_success(std::string_view text) {
  print(fmt::format("{}\n", text), stdout, stdout_is_journal(), kInfoPriority);
}

}  // namespace kasumi
