// kasumi as a process of its own, on the bench's recording.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/places.hpp"

namespace kasumi {

using SteadyClock = std::chrono::steady_clock;

// What is awaited here comes in the end; a limit only keeps a test from waiting forever. Under a sanitizer everything
// takes longer, the drawing of pictures most.
#if defined(__SANITIZE_THREAD__)
constexpr int kSlowness = 10;
#elif defined(__SANITIZE_ADDRESS__)
constexpr int kSlowness = 3;
#else
constexpr int kSlowness = 1;
#endif

// The nice value of that process's thread of that name; empty: it has none.
inline std::optional<int> nice_of(pid_t process, const std::string& thread) {
  std::error_code error;
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", process), error))
    if (read_text_file(task.path() / "comm").value_or("") == thread + "\n")
      return ::getpriority(PRIO_PROCESS, static_cast<id_t>(std::stoi(task.path().filename().string())));
  return std::nullopt;
}

class Process {
 public:
  // `notify`: the service manager's socket. `state`: the service's state folder; empty: not started by the service.
  // `variables`: added to the environment.
  Process(const std::filesystem::path& folder, std::vector<std::string> arguments, const std::string& notify = {},
          const std::filesystem::path& state = {},
          const std::vector<std::pair<std::string, std::string>>& variables = {})
      : log_(folder / "log.txt") {
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int log = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(log, STDERR_FILENO);
    ::dup2(log, STDOUT_FILENO);
    if (!notify.empty()) ::setenv("NOTIFY_SOCKET", notify.c_str(), 1);
    ::setenv("RUNTIME_DIRECTORY", folder.c_str(), 1);
    if (!state.empty()) ::setenv("STATE_DIRECTORY", state.c_str(), 1);
    for (const auto& [name, value] : variables) ::setenv(name.c_str(), value.c_str(), 1);
    if (const char* options = std::getenv("TSAN_OPTIONS")) {
      // Its deadlock detector gives up at 64 held locks, of which the GL driver leaves some with each reload.
      ::setenv("TSAN_OPTIONS", (std::string(options) + ":detect_deadlocks=0").c_str(), 1);
    }
    std::vector<char*> argv;
    std::string program = kasumi_program().string();
    argv.push_back(program.data());
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  void send(int signal) { ::kill(pid_, signal); }
  // The exit code; empty when it does not end.
  std::optional<int> wait(std::chrono::milliseconds longest) {
    const auto deadline = SteadyClock::now() + kSlowness * longest;
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
      if (SteadyClock::now() > deadline) return std::nullopt;
      std::this_thread::sleep_for(5ms);
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  pid_t id() const { return pid_; }
  bool runs() const {
    siginfo_t ended{};
    return ::waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
  }
  std::string log() const { return read_text_file(log_).value_or(""); }

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
};

template <class Condition>
bool eventually(Condition condition, std::chrono::seconds longest = 60s) {
  const auto deadline = SteadyClock::now() + kSlowness * longest;
  while (!condition()) {
    if (SteadyClock::now() > deadline) return false;
    std::this_thread::sleep_for(20ms);
  }
  return true;
}

inline std::filesystem::path process_folder(const std::string& name) {
  const auto folder = test_output_folder() / "pipeline" / ("process-" + name);
  std::filesystem::remove_all(folder);
  write_config(folder);
  return folder;
}

inline nlohmann::json status_in(const std::filesystem::path& folder) {
  const auto text = read_text_file(folder / "status.json");
  return text ? parse_json(*text) : nlohmann::json();
}

}  // namespace kasumi
