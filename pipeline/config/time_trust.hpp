// Whether the machine's time can be trusted. At boot it may be wrong by years, and so would be the sun's position.
#pragma once

#include <cstdint>
#include <memory>

#include "base/clock.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"

namespace kasumi {

enum class ClockPolicy {
  synchronized,  // trusted once the kernel reports it as synchronized
  trusted,       // always trusted: set by other means, or the cameras play a recording
  from_sky,      // as `synchronized`; until then the sky camera locates the sun
};
struct ClockOptions {
  ClockPolicy policy = ClockPolicy::synchronized;
  Utc earliest{};  // an earlier time is never trusted
};

// The kernel's state of its clock.
struct ClockState {
  bool synchronized = false;  // adjtimex without STA_UNSYNC
  std::uint64_t jumps = 0;    // how often it was set since watching began
};
class TimeWatch {
 public:
  virtual ~TimeWatch() = default;
  virtual ClockState read() = 0;  // does not block; one thread only
};
// Uses adjtimex and a timer that the kernel cancels when the clock is set.
std::unique_ptr<TimeWatch> watch_kernel_time();

class TimeTrust {
 public:
  explicit TimeTrust(ClockOptions options = {}) : options_(options) {}
  // Where to take the sun's position from now. Trust, once gained, lasts until somebody sets the clock: a machine cut
  // off from its time server drifts only by seconds a day.
  SunSource judge(const ClockState& state, Utc now);

 private:
  ClockOptions options_;
  bool gained_ = false;
  std::uint64_t jumps_ = 0;
};

}  // namespace kasumi
