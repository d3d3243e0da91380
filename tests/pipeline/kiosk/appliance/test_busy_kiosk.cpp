// Everything at once that operators, curators and those who look on ask of a kiosk: its watchdog hears of pictures all the
// while.
#include <atomic>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"
#include "tests/pipeline/service_manager.hpp"

namespace kasumi {
namespace {

constexpr auto kTogether = 20s;        // for so long all is asked at once
constexpr double kLongestSilence = 5;  // s; the unit's WatchdogSec= is 20
constexpr int kReaders = 200;

// Does something again and again, in threads of its own, until it goes.
class Askers {
 public:
  ~Askers() { end(); }
  void add(std::function<bool()> ask, std::atomic<int>& answered, std::chrono::milliseconds pause = 0ms) {
    threads_.emplace_back([this, ask = std::move(ask), &answered, pause] {
      while (!stop_) {
        if (ask()) ++answered;
        std::this_thread::sleep_for(pause);
      }
    });
  }
  void end() {
    stop_ = true;
    for (auto& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

std::size_t count_of(const std::string& words, const std::string& in) {
  std::size_t count = 0;
  for (auto at = in.find(words); at != std::string::npos; at = in.find(words, at + words.size())) ++count;
  return count;
}

// The longest time without one of the watchdog's messages, s, with what is not over yet.
class Silence {
 public:
  explicit Silence(ServiceManager& manager) : manager_(manager) { listen(); }
  void listen() {
    const auto now = SteadyClock::now();
    const auto heard = count_of("WATCHDOG=1", manager_.heard());
    longest_ = std::max(longest_, std::chrono::duration<double>(now - last_).count());
    if (heard > heard_) last_ = now;
    heard_ = heard;
  }
  double longest() const { return longest_; }
  std::size_t heard() const { return heard_; }

 private:
  ServiceManager& manager_;
  SteadyClock::time_point last_ = SteadyClock::now();
  std::size_t heard_ = 0;
  double longest_ = 0;
};

TEST(BusyKiosk, Row36TheWatchdogHearsOfPicturesWhileEverythingIsAskedAtOnce) {
  const auto folder = process_folder("busy");
  const auto content = folder / "content", status = folder / "status.json";
  for (const char* name : {"spring", "autumn"}) packed(write_desk(folder / "desks" / name), name, kMonday);
  const auto kasumi_command = [&](const std::string& arguments) {
    return shell(fmt::format("{} {}", kasumi_program().string(), arguments)) == 0;
  };
  const auto install = [&](const std::string& name) {
    return kasumi_command(fmt::format("content install {}/desks/{}.kasumi --content {} --unsigned --again --status {}",
                                      folder.string(), name, content.string(), status.string()));
  };
  ServiceManager manager;
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string(), "--content", content.string()},
                 manager.path());
  ASSERT_TRUE(eventually([&] { return status_in(folder)["shown"] == "live"; })) << kasumi.log();

  std::atomic<int> reloads = 0, installed = 0, taken_back = 0, snapshots = 0, reads = 0;
  Silence silence(manager);
  {
    Askers askers;
    const auto hang_up = [&] {
      kasumi.send(SIGHUP);
      return true;
    };
    askers.add(hang_up, reloads, 300ms);
    askers.add(
        [&, turn = 0]() mutable {
          if (!install(turn++ % 2 ? "spring" : "autumn")) return false;
          if (kasumi_command(fmt::format("content rollback --content {} --config {}/kasumi.toml --status {}",
                                         content.string(), folder.string(), status.string())))
            ++taken_back;
          return true;
        },
        installed);
    askers.add([&] { return kasumi_command(fmt::format("snapshot --folder {0} --out {0}/now.png", folder.string())); },
               snapshots);
    for (int i = 0; i < kReaders; ++i) askers.add([&] { return status_in(folder).is_object(); }, reads, 100ms);
    for (const auto end = SteadyClock::now() + kSlowness * kTogether; SteadyClock::now() < end;) {
      silence.listen();
      std::this_thread::sleep_for(5ms);
    }
  }
  std::printf(
      "36 %d reloads, %d bundles installed and %d taken back, %d snapshots and %d reads of the status: %zu messages to "
      "the watchdog, the longest time without one %.2f s\n",
      reloads.load(), installed.load(), taken_back.load(), snapshots.load(), reads.load(), silence.heard(),
      silence.longest());
  for (const auto* count : {&reloads, &installed, &taken_back, &snapshots, &reads}) EXPECT_GE(*count, 1);
  EXPECT_TRUE(kasumi.runs());
  EXPECT_LE(silence.longest(), kSlowness * kLongestSilence) << kasumi.log();
}

}  // namespace
}  // namespace kasumi
