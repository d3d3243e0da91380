// The first pass over the pictures of a call, before any is answered: for properties that need several of one camera.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "pipeline/lab/photographs/camera_memory.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"

namespace kasumi {

constexpr std::size_t kMostAsked = 48;  // pictures whose air is estimated for their tone curves: more add little

// The cameras by their pictures and by `before`. Pictures that cannot be read are skipped; they are reported when their
// turn comes. `cameras`: EstimateInputs::cameras(). `kept`: later calls use the memory, so that a camera's only picture
// counts, too.
std::shared_ptr<const CameraMemory> learn_cameras(const std::vector<EstimateInput>& pictures,
                                                  const std::vector<PhotographSetup>& cameras, CameraMemory before,
                                                  bool kept, std::size_t threads, std::size_t most_asked = kMostAsked);

}  // namespace kasumi
