// The first look at the pictures of a call, before any is answered: for what only several of one camera tell.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "pipeline/lab/photographs/camera_memory.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"

namespace kasumi {

// What the pictures, and `before`, tell of their cameras. Those that cannot be read are passed over; they are reported
// when their turn comes. `cameras`: EstimateInputs::cameras(). `kept`: later calls ask the memory, so that a camera's
// only picture is worth a look, too.
std::shared_ptr<const CameraMemory> learn_cameras(const std::vector<SkyInput>& pictures,
                                                  const std::vector<SkyPhotographOptions>& cameras, CameraMemory before,
                                                  bool kept, std::size_t threads);

}  // namespace kasumi
