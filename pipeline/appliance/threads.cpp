#include "pipeline/appliance/threads.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <thread>

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include "pipeline/appliance/appliance.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFrameTimeout = 200ms;       // for a frame: then a camera's loop checks whether to stop
constexpr Duration kShutdownDeadline = 1500ms;  // for all threads together

// A request to stop, never withdrawn; wakes every waiting thread.
class Stop {
 public:
  Stop(Clock& clock, Notifier& notifier) : clock_(clock), notifier_(notifier) {}
  void add(Bell& bell) { bells_.push_back(&bell); }
  void now() {
    if (stopping_.exchange(true)) return;
    notifier_.stopping();
    clock_.interrupt();
    for (auto* bell : bells_) bell->ring();
  }
  bool wanted() const { return stopping_; }

 private:
  Clock& clock_;
  Notifier& notifier_;
  std::vector<Bell*> bells_;
  std::atomic<bool> stopping_ = false;
};

std::thread start(const char* name, std::function<void()> run) {
  return std::thread([name, run = std::move(run)] {
    ::pthread_setname_np(::pthread_self(), name);
    run();
  });
}

sigset_t our_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set, signal);
  return set;
}

void wait_for_signals(Stop& stop, Bell& reload, Bell& ended) {
  const auto set = our_signals();
  while (!stop.wanted()) {
    const timespec timeout{0, 200'000'000};
    const int signal = ::sigtimedwait(&set, nullptr, &timeout);
    if (signal == SIGHUP) reload.ring();
    if (signal == SIGTERM || signal == SIGINT) stop.now();
  }
  if (ended.wait_for(kShutdownDeadline)) return;
  // A thread is stuck in a driver or a disk. Files are replaced atomically, so exiting now corrupts nothing.
  spdlog::warn("a thread is stuck in a driver or a disk: exiting without it");
  std::_Exit(EXIT_SUCCESS);
}

}  // namespace

Result<> run_appliance(const std::filesystem::path& config_file, ContentPtr content, StatusOptions status) {
  const auto signals = our_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  SystemClock clock;
  const auto devices = machine_devices(clock);
  const auto time = watch_kernel_time();
  const auto notifier = notify_systemd();
  Appliance appliance(config_file, std::move(content), {*devices, clock, *time, *notifier}, std::move(status));
  Bell reload, status_bell, check_bell, ended;
  Stop stop(clock, *notifier);
  for (auto* bell : {&reload, &status_bell, &check_bell, &appliance.render_bell()}) stop.add(*bell);

  auto guard = start("signals", [&] { wait_for_signals(stop, reload, ended); });
  std::vector<std::thread> loops;
  loops.push_back(start("scene", [&] {
    while (!stop.wanted()) appliance.scene().step(clock.now() + kFrameTimeout);
  }));
  loops.push_back(start("sky", [&] {
    while (!stop.wanted()) appliance.sky().step(clock.now() + kFrameTimeout);
  }));
  loops.push_back(start("reload", [&] {
    while (!stop.wanted())
      if (reload.wait_for(1h) && !stop.wanted()) appliance.reload();
  }));
  loops.push_back(start("status", [&] {
    while (!stop.wanted()) {
      appliance.status().step();
      status_bell.wait_for(1s);
    }
  }));
  loops.push_back(start("check", [&] {
    // Lowest priority: it may take its time.
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 19);
    while (!stop.wanted()) {
      const auto again = std::min(appliance.check().step(), appliance.visibility().step());
      check_bell.wait_for(again - clock.now());
    }
  }));
  auto& render = appliance.render();
  while (!stop.wanted()) {
    const auto again = render.step();
    if (render.closed()) stop.now();
    appliance.render_bell().wait_for(again - clock.now());
  }

  for (auto& loop : loops) loop.join();
  render.finish();
  appliance.status().finish();
  ended.ring();
  guard.join();
  return {};
}

}  // namespace kasumi
