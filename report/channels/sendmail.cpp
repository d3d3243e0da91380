#include "report/channels/sendmail.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>

namespace kasumi::report {

namespace {

constexpr std::size_t kMostWords = 400;

std::string error_text() {
  return std::strerror(errno);
}

}  // namespace

Result<Sendmail> Sendmail::start(const std::vector<std::string>& command, std::string_view mail, Clock& clock) {
  // Its whole input lies there before it starts, so that one that does not read holds nobody up.
  const UniqueFd input(::memfd_create("mail", MFD_CLOEXEC));
  if (!input) return fail(FaultKind::io, "mail: {}", error_text());
  for (auto rest = mail; !rest.empty();) {
    const auto n = ::write(input.value(), rest.data(), rest.size());
    if (n < 0) return fail(FaultKind::io, "mail: {}", error_text());
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  ::lseek(input.value(), 0, SEEK_SET);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(FaultKind::io, "mail: {}", error_text());
  UniqueFd said(ends[0]);
  const UniqueFd saying(ends[1]);
  ::fcntl(said.value(), F_SETFL, O_NONBLOCK);

  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_adddup2(&files, input.value(), 0);
  ::posix_spawn_file_actions_adddup2(&files, saying.value(), 1);
  ::posix_spawn_file_actions_adddup2(&files, saying.value(), 2);
  ::posix_spawn_file_actions_addclosefrom_np(&files, 3);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t usual;  // which we ignore, and it must not
  ::sigemptyset(&usual);
  ::sigaddset(&usual, SIGPIPE);
  ::posix_spawnattr_setsigdefault(&attributes, &usual);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_t pid = -1;
  const int error = ::posix_spawn(&pid, words[0], &files, &attributes, words.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) return fail(FaultKind::io, "{}: cannot be started: {}", command[0], std::strerror(error));
  return Sendmail(pid, std::move(said), command[0], clock);
}

Sendmail::Sendmail(Sendmail&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      said_(std::move(other.said_)),
      program_(std::move(other.program_)),
      words_(std::move(other.words_)),
      clock_(other.clock_),
      began_(other.began_),
      killed_(other.killed_) {}

Sendmail::~Sendmail() {
  if (pid_ <= 0) return;
  ::kill(-pid_, SIGKILL);
  for (int i = 0; i < 100 && ::waitpid(pid_, nullptr, WNOHANG) == 0; ++i) ::usleep(10000);
}

void Sendmail::listen() {
  std::array<char, 1024> buffer;
  // One that says more than we read waits, until it is killed.
  const auto n = ::read(said_.value(), buffer.data(), buffer.size());
  for (ssize_t i = 0; i < n; ++i) {
    const char c = buffer[static_cast<std::size_t>(i)];
    if (words_.ends_with('\n')) words_.clear();
    const bool printable = c == '\n' || static_cast<unsigned char>(c) >= 0x20;
    if (words_.size() < kMostWords || c == '\n') words_ += printable ? c : ' ';
  }
}

std::optional<Result<>> Sendmail::turn() {
  listen();
  int status = 0;
  const auto done = ::waitpid(pid_, &status, WNOHANG);
  const auto age = clock_.now() - began_;
  if (done == 0) {
    if (age >= kLongest && !std::exchange(killed_, true)) ::kill(-pid_, SIGKILL);
    if (age < 2 * kLongest) return std::nullopt;
  }
  if (killed_) {
    if (done != 0) pid_ = -1;
    return Result<>(fail(FaultKind::io, "{}: has not ended in {:.0f} s", program_, to_seconds(kLongest)));
  }
  // What it started may go on in peace, as a queue's daemon.
  pid_ = -1;
  if (done > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0) return Result<>();
  listen();
  while (words_.ends_with('\n')) words_.pop_back();
  const auto code = WIFEXITED(status) ? fmt::format("exit code {}", WEXITSTATUS(status))
                                      : fmt::format("killed by signal {}", WTERMSIG(status));
  return Result<>(fail(FaultKind::io, "{}: {}{}{}", program_, code, words_.empty() ? "" : ": ", words_));
}

}  // namespace kasumi::report
