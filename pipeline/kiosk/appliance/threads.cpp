#include "pipeline/kiosk/appliance/threads.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include "pipeline/kiosk/appliance/appliance.hpp"
#include "pipeline/kiosk/loop/loop_guard.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/time_watch.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFrameTimeout = 200ms;       // for a frame: then a camera's loop checks whether to stop
constexpr Duration kShutdownDeadline = 1500ms;  // for all threads together
constexpr Duration kExchangeDeadline = 1min;    // the same where other content comes next

// A request to stop, never withdrawn; wakes every waiting thread.
class Stop {
 public:
  Stop(Clock& clock, Notifier& notifier) : clock_(clock), notifier_(notifier) {}
  void add(Bell& bell) { bells_.push_back(&bell); }
  enum class Why { for_good, other_content };
  void now(Why why = Why::for_good) {
    if (why != Why::for_good && !stopping_) for_good_ = false;
    if (stopping_.exchange(true)) return;
    if (for_good_) notifier_.stopping();
    clock_.interrupt();
    for (auto* bell : bells_) bell->ring();
  }
  bool wanted() const { return stopping_; }
  bool for_good() const { return for_good_; }

 private:
  Clock& clock_;
  Notifier& notifier_;
  std::vector<Bell*> bells_;
  std::atomic<bool> stopping_ = false, for_good_ = true;
};

std::thread start(const char* name, std::function<void()> run) {
  return std::thread([name, run = std::move(run)] {
    ::pthread_setname_np(::pthread_self(), name);
    run();
  });
}

// Until `stop`; a step that throws is taken again after a pause.
void keep_stepping(const char* name, Clock& clock, const Stop& stop, const std::function<void()>& step) {
  LoopGuard guard(name, clock);
  while (!stop.wanted())
    if (!guard.run(step) && !stop.wanted()) clock.sleep_until(guard.again_at());
}

sigset_t our_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set, signal);
  return set;
}

void wait_for_signals(Stop& stop, ReloadLoop& reload, Notifier& notifier, Bell& ended) {
  const auto set = our_signals();
  while (!stop.wanted()) {
    const timespec timeout{0, 200'000'000};
    const int signal = ::sigtimedwait(&set, nullptr, &timeout);
    if (signal == SIGHUP) reload.ask();
    if (signal == SIGTERM || signal == SIGINT) stop.now();
  }
  const auto deadline = stop.for_good() ? kShutdownDeadline : kExchangeDeadline;
  // Where other content comes, the still picture stays on the glass meanwhile, which is life enough; a check on a busy
  // machine may take long to end.
  for (Duration waited{}; waited < deadline; waited += 500ms) {
    if (ended.wait_for(500ms)) return;
    if (!stop.for_good()) notifier.alive();
  }
  // Stuck in a driver or a disk, or a check on a busy machine. Files are replaced atomically, so exiting corrupts nothing.
  spdlog::warn("a thread did not end within {:.1f} s: exiting without it", to_seconds(deadline));
  std::_Exit(stop.for_good() ? EXIT_SUCCESS : EXIT_FAILURE);
}

}  // namespace

std::string run_appliance(const ContentPlace& place, ContentPtr content, StatusOutputs status, StartLog& starts,
                          const std::filesystem::path& kept_folder) {
  const auto signals = our_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  static SystemClock log_clock;  // something may be logged after this function's clock has gone
  bound_log(log_clock);
  SystemClock clock;
  const auto machine = machine_devices(clock);
  const auto devices = resting(*machine, starts.record(), clock);
  const auto runtime = service_folders().runtime;
  const auto time = remember_trust(watch_time(), runtime.empty() ? runtime : runtime / "clock.json");
  const auto notifier = notify_systemd();
  Appliance appliance(place, std::move(content), {*devices, clock, *time, *notifier, {&starts, kept_folder}},
                      std::move(status));
  Bell status_bell, check_bell, proving_bell, ended;
  Stop stop(clock, *notifier);
  for (auto* bell : {&status_bell, &check_bell, &proving_bell, &appliance.horizon_bell(), &appliance.television_bell(),
                     &appliance.reload_bell(), &appliance.snapshot_bell(), &appliance.render_bell()})
    stop.add(*bell);

  auto guard = start("signals", [&] { wait_for_signals(stop, appliance.reload(), *notifier, ended); });
  std::vector<std::thread> loops;
  loops.push_back(start("scene", [&] {
    keep_stepping("scene camera's loop", clock, stop, [&] { appliance.scene().step(clock.now() + kFrameTimeout); });
  }));
  loops.push_back(start("sky", [&] {
    keep_stepping("sky camera's loop", clock, stop, [&] { appliance.sky().step(clock.now() + kFrameTimeout); });
  }));
  loops.push_back(start("horizon", [&] {
    keep_stepping("horizon", clock, stop,
                  [&] { appliance.horizon_bell().wait_for(appliance.horizon().step() - clock.now()); });
  }));
  loops.push_back(start("reload", [&] {
    keep_stepping("reload", clock, stop,
                  [&] { appliance.reload_bell().wait_for(appliance.reload().step() - clock.now()); });
  }));
  loops.push_back(start("status", [&] {
    keep_stepping("status", clock, stop, [&] {
      appliance.status().step();
      status_bell.wait_for(1s);
    });
    // At once, since the other threads may not end in time.
    LoopGuard("status", clock).run([&] { appliance.status().keep(); });
  }));
  loops.push_back(start("check", [&] {
    // Lowest priority: it may take its time.
    if (::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 19) != 0)
      spdlog::warn("the daily check runs at the picture's own priority: {}", std::strerror(errno));
    keep_stepping("check", clock, stop, [&] {
      const auto again = std::min(appliance.check().step(), appliance.visibility().step());
      check_bell.wait_for(again - clock.now());
    });
  }));
  loops.push_back(start("television", [&] {
    keep_stepping("television", clock, stop,
                  [&] { appliance.television_bell().wait_for(appliance.step_television() - clock.now()); });
  }));
  // Not beside the check: on a busy machine that thread stands still for minutes, and so would a probation.
  loops.push_back(start("proving", [&] {
    keep_stepping("proving", clock, stop, [&] { proving_bell.wait_for(appliance.proving().step() - clock.now()); });
  }));
  loops.push_back(
      start("snapshot", [&] { keep_stepping("snapshot", clock, stop, [&] { appliance.snapshot().step(); }); }));
  auto& render = appliance.render();
  while (!stop.wanted()) {
    const auto again = render.step();
    if (render.closed()) stop.now();
    if (!render.refused().empty()) stop.now(Stop::Why::other_content);
    appliance.render_bell().wait_for(again - clock.now());
  }

  if (render.refused().empty()) starts.ended();
  for (auto& loop : loops) loop.join();
  render.finish();
  LoopGuard("status", clock).run([&] { appliance.status().finish(); });
  ended.ring();
  guard.join();
  return render.refused();
}

}  // namespace kasumi
