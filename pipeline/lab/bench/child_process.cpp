#include "pipeline/lab/bench/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

extern char** environ;

namespace kasumi {
namespace {

using std::chrono::steady_clock;

// `kept`: a descriptor that the program inherits; `errors`: where its standard error goes; -1: none.
Result<pid_t> spawn(const std::vector<std::string>& command, int kept = -1, int errors = -1) {
  std::vector<char*> words;
  for (const auto& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  for (const int output : {STDOUT_FILENO, STDERR_FILENO})
    ::posix_spawn_file_actions_addopen(&actions, output, "/dev/null", O_WRONLY, 0);
  if (errors >= 0) ::posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO);
  if (kept >= 0) ::posix_spawn_file_actions_adddup2(&actions, kept, kept);  // clears close-on-exec
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, words.front(), &actions, nullptr, words.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fail(FaultKind::io, "{}: cannot be started: {}", command.front(), std::strerror(error));
  return child;
}

double timeval_seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string last_line_of(int file) {
  std::array<char, 4096> end{};
  const off_t size = ::lseek(file, 0, SEEK_END);
  const auto from = std::max<off_t>(0, size - static_cast<off_t>(end.size()));
  const auto got = ::pread(file, end.data(), end.size(), from);
  std::string text(end.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  const auto line = text.rfind('\n');
  return line == std::string::npos ? text : text.substr(line + 1);
}

}  // namespace

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

Result<ChildCost> run_child(const std::vector<std::string>& command, Duration at_most) {
  const auto started = steady_clock::now();
  const UniqueFd errors(::memfd_create("errors", MFD_CLOEXEC));
  const auto child = spawn(command, -1, errors.value());
  if (!child) return fail(child.error());
  ChildCost cost;
  int status = 0;
  rusage used{};
  while (true) {
    const pid_t ended = ::wait4(*child, &status, WNOHANG, &used);
    cost.wall_s = std::chrono::duration<double>(steady_clock::now() - started).count();
    if (ended == *child) break;
    if (ended < 0) return fail(FaultKind::io, "{}: cannot be waited for", command.front());
    if (steady_clock::now() - started > at_most) {
      ::kill(*child, SIGKILL);
      ::waitpid(*child, &status, 0);
      return fail(FaultKind::timeout, "{}: still running after {:.0f} s", command.front(), cost.wall_s);
    }
    ::usleep(2000);
  }
  cost.processor_s = timeval_seconds(used.ru_utime) + timeval_seconds(used.ru_stime);
  cost.last_words = last_line_of(errors.value());
  cost.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return cost;
}

Result<Child> Child::start(const std::vector<std::string>& command) {
  UniqueFd errors(::memfd_create("errors", MFD_CLOEXEC));
  const auto child = spawn(command, -1, errors.value());
  if (!child) return fail(child.error());
  return Child(*child, std::move(errors));
}

Child::~Child() {
  if (pid_ == 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool Child::is_running() const {
  siginfo_t ended{};
  return ::waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
}

std::string Child::last_words() const {
  return last_line_of(errors_.value());
}

WorkFolder::WorkFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kasumi-bench-XXXXXX").string();
  if (::mkdtemp(name.data())) path_ = name;
}

WorkFolder::~WorkFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

Result<VirtualDesktop> VirtualDesktop::start(int width, int height) {
  if (!is_installed("Xvfb")) return fail(FaultKind::unsupported, "neither a desktop nor Xvfb is here");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return fail(FaultKind::io, "no pipe to Xvfb");
  const UniqueFd reader(ends[0]);
  UniqueFd writer(ends[1]);
  // -noreset: it stays as it is when its last window has closed.
  const auto server = spawn({"Xvfb", "-displayfd", std::to_string(writer.value()), "-noreset", "-nolisten", "tcp",
                             "-screen", "0", fmt::format("{}x{}x24", width, height)},
                            writer.value());
  if (!server) return fail(server.error());
  writer = UniqueFd();
  VirtualDesktop desktop(*server);
  // Read to its line break: the server ends when it can no longer write it.
  std::string number;
  while (!number.ends_with('\n')) {
    pollfd ready{reader.value(), POLLIN, 0};
    char next = 0;
    if (::poll(&ready, 1, 10'000) != 1 || ::read(reader.value(), &next, 1) != 1)
      return fail(FaultKind::timeout, "Xvfb opened no display within 10 s");
    number += next;
  }
  number.pop_back();
  ::setenv("DISPLAY", (":" + number).c_str(), 1);
  return desktop;
}

VirtualDesktop::~VirtualDesktop() {
  if (server_ == 0) return;
  ::unsetenv("DISPLAY");
  ::kill(server_, SIGTERM);
  ::waitpid(server_, nullptr, 0);
}

}  // namespace kasumi
