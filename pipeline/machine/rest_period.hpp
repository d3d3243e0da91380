// Cameras that are left alone for a while after a start: those whose opening hung at the starts before it.
#pragma once

#include <memory>
#include <string>

#include "pipeline/machine/devices.hpp"

namespace kasumi {

struct RestPeriod {
  Duration lasts{};  // 0: none
  std::string why;   // the cause in its health meanwhile
};

// `devices` whose cameras rest from now on, each at its first opening alone: not those of a configuration that is
// loaded later. Unplugging a camera ends its rest. Both must outlive it.
std::unique_ptr<Devices> resting(Devices& devices, const RestPeriod& scene, const RestPeriod& sky, Clock& clock);

}  // namespace kasumi
