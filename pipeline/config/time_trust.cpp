#include "pipeline/config/time_trust.hpp"

#include <sys/timerfd.h>
#include <sys/timex.h>

#include <cerrno>
#include <limits>

#include <unistd.h>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

class KernelTimeWatch final : public TimeWatch {
 public:
  KernelTimeWatch() : timer_(timerfd_create(CLOCK_REALTIME, TFD_NONBLOCK | TFD_CLOEXEC)) { arm(); }

  ClockState read() override {
    std::uint64_t expired = 0;
    if (timer_ && ::read(timer_.value(), &expired, sizeof expired) < 0 && errno == ECANCELED) {
      ++state_.jumps;
      arm();
    }
    struct timex kernel {};
    state_.synchronized = ::adjtimex(&kernel) >= 0 && (kernel.status & STA_UNSYNC) == 0;
    return state_;
  }

 private:
  void arm() {
    struct itimerspec never {};
    never.it_value.tv_sec = std::numeric_limits<time_t>::max();
    if (timer_) ::timerfd_settime(timer_.value(), TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &never, nullptr);
  }

  UniqueFd timer_;
  ClockState state_;
};

}  // namespace

std::unique_ptr<TimeWatch> watch_kernel_time() {
  return std::make_unique<KernelTimeWatch>();
}

SunSource TimeTrust::judge(const ClockState& state, Utc now) {
  if (state.jumps != jumps_) gained_ = false;
  jumps_ = state.jumps;
  gained_ = gained_ || state.synchronized;
  const bool trusted = now >= options_.earliest && (gained_ || options_.policy == ClockPolicy::trusted);
  if (trusted) return SunSource::ephemeris;
  return options_.policy == ClockPolicy::from_sky ? SunSource::image : SunSource::none;
}

}  // namespace kasumi
