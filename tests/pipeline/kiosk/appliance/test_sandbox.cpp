// The program under the filter of system calls that its unit puts around it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <map>
#include <set>
#include <thread>

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

// What the unit is strict about and somebody might want: its own priorities, and the clock.
const std::map<std::string, unsigned> kCalls{{"setpriority", SYS_setpriority},
                                             {"sched_setattr", SYS_sched_setattr},
                                             {"sched_setscheduler", SYS_sched_setscheduler},
                                             {"sched_setparam", SYS_sched_setparam},
                                             {"sched_setaffinity", SYS_sched_setaffinity},
                                             {"ioprio_set", SYS_ioprio_set},
                                             {"mbind", SYS_mbind},
                                             {"adjtimex", SYS_adjtimex},
                                             {"clock_adjtime", SYS_clock_adjtime},
                                             {"clock_settime", SYS_clock_settime},
                                             {"settimeofday", SYS_settimeofday}};

// The calls of a group, as systemd knows them; groups within it, too. Empty: there is no systemd here to ask.
std::set<std::string> calls_of(const std::string& group) {
  std::set<std::string> calls;
  FILE* pipe = ::popen(("systemd-analyze syscall-filter " + group + " 2>/dev/null").c_str(), "r");
  std::array<char, 256> line;
  while (pipe && std::fgets(line.data(), line.size(), pipe)) {
    std::istringstream words(line.data());
    std::string word;
    words >> word;
    if (word.empty() || word == group || word.starts_with('#')) continue;
    if (word.starts_with('@'))
      calls.merge(calls_of(word));
    else
      calls.insert(word);
  }
  if (pipe) ::pclose(pipe);
  return calls;
}

std::set<std::string> allowed_by(const std::filesystem::path& unit) {
  std::set<std::string> allowed;
  std::istringstream lines(read_text_file(unit).value());
  bool protect_clock = false;
  for (std::string line; std::getline(lines, line);) {
    protect_clock = protect_clock || line == "ProtectClock=yes";
    if (!line.starts_with("SystemCallFilter=")) continue;
    const bool deny = line[17] == '~';
    std::istringstream words(line.substr(deny ? 18 : 17));
    for (std::string word; words >> word;) {
      const auto calls = word.starts_with('@') ? calls_of(word) : std::set<std::string>{word};
      for (const auto& call : calls) {
        if (deny)
          allowed.erase(call);
        else
          allowed.insert(call);
      }
    }
  }
  if (protect_clock)
    for (const auto& call : calls_of("@clock")) allowed.erase(call);
  return allowed;
}

// From now on this process, and what it becomes, is refused these calls with EPERM.
void refuse(const std::set<unsigned>& calls) {
  std::vector<sock_filter> program{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
  for (const unsigned call : calls) {
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM));
  }
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) ::_exit(126);
}

TEST(Sandbox, TheDailyCheckStepsBehindAllOthersAndThePictureIsLive) {
  const auto allowed = allowed_by(source_folder() / "systemd/kasumi.service");
  if (allowed.size() < 100) GTEST_SKIP() << "systemd-analyze is not installed";
  std::set<unsigned> refused;
  for (const auto& [name, number] : kCalls)
    if (!allowed.contains(name)) refused.insert(number);
  EXPECT_TRUE(refused.contains(SYS_adjtimex)) << "the unit keeps the clock to itself";
  EXPECT_TRUE(refused.contains(SYS_sched_setscheduler));

  const auto folder = test_output_folder() / "pipeline" / "sandbox";
  std::filesystem::remove_all(folder);
  const auto config = write_config(folder).string();
  const auto program = kasumi_program().string();
  const auto pid = ::fork();
  if (pid == 0) {
    ::dup2(::open((folder / "log.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), STDERR_FILENO);
    ::setenv("RUNTIME_DIRECTORY", folder.c_str(), 1);
    refuse(refused);
    ::execl(program.c_str(), program.c_str(), "run", "--config", config.c_str(), nullptr);
    ::_exit(127);
  }
  const auto shown = [&] {
    const auto text = read_text_file(folder / "status.json");
    const auto json = text ? parse_json(*text) : nlohmann::json();
    return json.is_object() ? json["shown"].get<std::string>() : std::string();
  };
  for (int i = 0; i < 600 && shown() != "live"; ++i) std::this_thread::sleep_for(100ms);
  EXPECT_EQ(shown(), "live") << read_text_file(folder / "log.txt").value_or("");
  EXPECT_EQ(nice_of(pid, "check"), 19) << read_text_file(folder / "log.txt").value_or("");
  EXPECT_LT(nice_of(pid, "scene").value_or(19), 19);
  ::kill(pid, SIGTERM);
  int status = 0;
  ::waitpid(pid, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace kasumi
