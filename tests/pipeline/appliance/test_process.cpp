// The appliance as a process: threads, signals, exit codes, notifications to the service manager.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/unique_fd.hpp"
#include "tests/pipeline/appliance/rig.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using SteadyClock = std::chrono::steady_clock;

// A service manager that only listens.
class Listener {
 public:
  explicit Listener(const std::filesystem::path& path)
      : path_(path), socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    std::filesystem::remove(path);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_.value(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  std::string path() const { return path_.string(); }
  // All messages so far.
  const std::string& heard() {
    char buffer[4096];
    for (ssize_t n; (n = ::recv(socket_.value(), buffer, sizeof buffer, 0)) > 0;)
      heard_.append(buffer, static_cast<std::size_t>(n)).append("\n");
    return heard_;
  }

 private:
  std::filesystem::path path_;
  UniqueFd socket_;
  std::string heard_;
};

class Process {
 public:
  Process(const std::filesystem::path& folder, std::vector<std::string> arguments, const std::string& notify = {})
      : log_(folder / "log.txt") {
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int log = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(log, STDERR_FILENO);
    ::dup2(log, STDOUT_FILENO);
    if (!notify.empty()) ::setenv("NOTIFY_SOCKET", notify.c_str(), 1);
    ::setenv("RUNTIME_DIRECTORY", folder.c_str(), 1);
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
    const auto deadline = SteadyClock::now() + longest;
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
      if (SteadyClock::now() > deadline) return std::nullopt;
      std::this_thread::sleep_for(5ms);
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  std::string log() const { return read_text_file(log_).value_or(""); }

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
};

template <class Condition>
bool eventually(Condition condition, std::chrono::seconds longest = 60s) {
  const auto deadline = SteadyClock::now() + longest;
  while (!condition()) {
    if (SteadyClock::now() > deadline) return false;
    std::this_thread::sleep_for(20ms);
  }
  return true;
}

std::filesystem::path process_folder(const std::string& name) {
  const auto folder = test_output_folder() / "pipeline" / ("process-" + name);
  std::filesystem::remove_all(folder);
  write_config(folder);
  return folder;
}

nlohmann::json status_in(const std::filesystem::path& folder) {
  const auto text = read_text_file(folder / "status.json");
  return text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
}

// The thread sanitizer makes everything ten times slower: a step in progress at shutdown may then exceed the deadline
// for stuck drivers and disks.
#ifdef __SANITIZE_THREAD__
constexpr bool kSlowedDown = true;
#else
constexpr bool kSlowedDown = false;
#endif

// Runs all threads: the main test for the thread sanitizer.
TEST(Process, RunsReloadsContentAndEndsWithinTwoSecondsOfSigterm) {
  const auto folder = process_folder("run");
  Listener manager(folder / "notify");
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string(), "--stats"}, manager.path());
  ASSERT_TRUE(eventually([&] { return manager.heard().find("READY=1") != std::string::npos; })) << kasumi.log();
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return status.is_object() && status["shown"] == "live" && status["turbidity"].is_number();
  })) << kasumi.log();

  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return status_in(folder)["content"]["reloaded_utc"].is_string(); })) << kasumi.log();
  EXPECT_THAT(manager.heard(), HasSubstr("RELOADING=1"));
  auto text = read_text_file(folder / "kasumi.toml").value();
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text + "\nnonsense = 1\n"));
  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return !status_in(folder)["content"]["problems"].empty(); })) << kasumi.log();
  EXPECT_THAT(status_in(folder)["content"]["problems"].dump(), HasSubstr("nonsense"));
  EXPECT_EQ(status_in(folder)["shown"], "live");

  const auto requested = SteadyClock::now();
  kasumi.send(SIGTERM);
  const auto code = kasumi.wait(kSlowedDown ? 60s : 20s);
  ASSERT_TRUE(code);
  const auto took = std::chrono::duration<double>(SteadyClock::now() - requested).count();
  EXPECT_EQ(*code, 0) << kasumi.log();
  std::printf("ended %.2f s after SIGTERM\n", took);
  EXPECT_LE(took, kSlowedDown ? 60.0 : 2.0);
  EXPECT_THAT(manager.heard(), HasSubstr("WATCHDOG=1"));
  EXPECT_THAT(manager.heard(), HasSubstr("STATUS=live"));
  EXPECT_THAT(manager.heard(), HasSubstr("STOPPING=1"));
  if (kSlowedDown && kasumi.log().find("ending without it") != std::string::npos) {
    std::puts("too slow to end in order: only the hard end was seen");
    return;
  }
  EXPECT_THAT(kasumi.log(), HasSubstr("capture to flip"));
  EXPECT_TRUE(std::filesystem::exists(folder / "state" / "turbidity.json"));
}

TEST(Process, SigintEndsItAsWell) {
  const auto folder = process_folder("int");
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string()});
  ASSERT_TRUE(eventually([&] { return status_in(folder).is_object(); })) << kasumi.log();
  kasumi.send(SIGINT);
  EXPECT_EQ(kasumi.wait(20s), 0);
}

TEST(Process, ABadConfigurationIsExitCode78WithEveryProblem) {
  const auto folder = process_folder("78");
  auto text = read_text_file(folder / "kasumi.toml").value();
  const auto put = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  put("[scene.camera]\nsource = \"replay\"", "[scene.camera]\nsource = \"replayed\"");
  put("kind = \"headless\"", "kind = \"kms\"\nmode = \"1920 by 1080\"");
  put("still.png", "still-that-is-not-there.png");
  put("language = \"en\"", "language = \"klingon\"");
  put("latitude_deg", "latitude_degrees");
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text));
  for (const bool check : {false, true}) {
    std::vector<std::string> arguments{"run", "--config", (folder / "kasumi.toml").string()};
    if (check) arguments.push_back("--check");
    Process kasumi(folder, arguments);
    EXPECT_EQ(kasumi.wait(20s), 78);
    for (const char* problem : {"replayed", "1920 by 1080", "still-that-is-not-there.png", "klingon", "latitude_deg"})
      EXPECT_THAT(kasumi.log(), HasSubstr(problem));
  }
}

TEST(Process, CheckReportsAValidConfiguration) {
  const auto folder = process_folder("check");
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string(), "--check"});
  EXPECT_EQ(kasumi.wait(60s), 0) << kasumi.log();
}

}  // namespace
}  // namespace kasumi
