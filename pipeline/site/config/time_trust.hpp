// Whether the machine's time can be trusted. At boot it may be wrong by years, and so would be the sun's position.
#pragma once

#include <cstdint>

#include "base/clock.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"

namespace kasumi {

enum class ClockPolicy {
  synchronized,  // trusted once the machine reports it as synchronized
  trusted,       // always trusted: set by other means, or the cameras play a recording
  from_sky,      // as `synchronized`; until then the sky camera locates the sun
};
struct ClockRules {
  ClockPolicy policy = ClockPolicy::synchronized;
  Utc earliest{};  // an earlier time is never trusted
};

// What the machine knows of its clock (pipeline/machine/time_watch.hpp).
struct ClockState {
  bool synchronized = false;  // by a time server or the like
  std::uint64_t jumps = 0;    // how often it was set since watching began
  bool remembered = false;    // it was synchronized in this boot before the program started, and has not been set since
};
class TimeWatch {
 public:
  virtual ~TimeWatch() = default;
  virtual ClockState read() = 0;  // does not block; one thread only
};

class TimeTrust {
 public:
  explicit TimeTrust(ClockRules options = {}) : options_(options) {}
  // Where to take the sun's position from now. Trust, once gained, lasts until the clock is set: a machine cut off from
  // its time server drifts only by seconds a day.
  SunSource judge(const ClockState& state, Utc now);
  // Other options from now on; trust that was gained stays.
  void adopt(const ClockRules& options) { options_ = options; }

 private:
  ClockRules options_;
  bool gained_ = false;
  std::uint64_t jumps_ = 0;
};

}  // namespace kasumi
