// New content under the live picture.
#pragma once

#include <gtest/gtest.h>

#include "tests/pipeline/kiosk/appliance/rig.hpp"

namespace kasumi {

// Advances, live all the time, until the reload has ended; its problems.
inline std::vector<std::string> problems_of_reload(Rig& rig) {
  rig.hang_up();
  rig.advance(Rig::kTick);
  const auto ended = rig.advance_until(
      [&] {
        EXPECT_EQ(rig.shown(), Shown::live);
        return rig.status().reload && rig.status().reload->doing.empty();
      },
      20s);
  EXPECT_TRUE(ended);
  return rig.status().reload->problems;
}

}  // namespace kasumi
