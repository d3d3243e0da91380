// Whether the machine's time is to be believed. At boot it may be years wrong, and the sun with it.
#pragma once

#include <cstdint>
#include <memory>

#include "base/clock.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"

namespace kasumi {

enum class ClockPolicy {
  synchronized,  // believed once the kernel says that something keeps it in step
  trusted,       // always believed: somebody else looks after it, or the cameras play a recording
  from_sky,      // as `synchronized`, and until then the sun is where the sky camera sees it
};
struct ClockOptions {
  ClockPolicy policy = ClockPolicy::synchronized;
  Utc earliest{};  // a time before that is never believed
};

// What the kernel knows of its clock.
struct ClockState {
  bool synchronized = false;  // adjtimex without STA_UNSYNC
  std::uint64_t jumps = 0;    // how often it was set since the watch began
};
class TimeWatch {
 public:
  virtual ~TimeWatch() = default;
  virtual ClockState read() = 0;  // does not block; for one thread
};
// By adjtimex and a timer that the kernel cancels when the clock is set.
std::unique_ptr<TimeWatch> watch_kernel_time();

class TimeTrust {
 public:
  explicit TimeTrust(ClockOptions options = {}) : options_(options) {}
  // Where the sun's place may be taken from now. Trust once gained stays while the clock runs on undisturbed (a machine
  // cut off from its time server drifts by seconds a day), and is to be gained anew when somebody sets the clock.
  SunSource judge(const ClockState& state, Utc now);

 private:
  ClockOptions options_;
  bool gained_ = false;
  std::uint64_t jumps_ = 0;
};

}  // namespace kasumi
