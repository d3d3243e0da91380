// When a frame was captured by its driver's timestamp, which may be anything.
#pragma once

#include <cstdint>

#include "base/clock.hpp"

namespace kasumi {

// Bounded, so that no arithmetic with it overflows: at most some 30 years either way.
Instant bounded_driver_time(std::int64_t seconds, std::int64_t nanoseconds);
// Bounded; a timestamp of 0 is none: now.
Instant bounded_driver_time(std::uint64_t nanoseconds, Instant now);
// UTC at that instant; now, if the instant cannot be of this clock: it lies ahead, or a minute and more back.
Utc utc_of_capture(Instant captured_at, const Clock& clock);

}  // namespace kasumi
