// The inner loops of estimator/haze/diffusion.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "estimator/haze/conductance.hpp"

namespace kasumi {

// What decides how much flows where. No steps: one surface.
struct FlowMap {
  Image<float> wanted_px2;
  const Image<float>*steps_along_row = nullptr, *steps_down_column = nullptr;
};

// Runs the passes in order, in place; the picture is mirrored at its edges and must be no smaller than any offset.
// Memory is slower than arithmetic, so a pass follows as soon as the rows it reads are done, with as many passes at a
// time as fit in the processor's cache.
void run_passes(const std::vector<FlowRule>& rules, const FlowMap& map, Image<glm::vec4>& light);

// Pass k of H Eq 11 with Eq 18.
void invariant_pass(const Image<glm::vec4>& from, const Image<float>& rate, double inner_px, int k,
                    Image<glm::vec4>& to);

}  // namespace kasumi
