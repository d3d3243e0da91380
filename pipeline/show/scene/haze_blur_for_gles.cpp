#include "pipeline/show/scene/haze_blur_for_gles.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

BlurInput haze_scene(const Image<glm::vec3>& light, const HazeRange& range) {
  BlurInput scene{light, range.range, range.steps_along_row, range.steps_down_column};
  for (auto* steps : {&scene.steps_along_row, &scene.steps_down_column})
    for (float& sum : steps->elements()) sum /= kRangeStepTurn;
  return scene;
}

HazeLook haze_look(const HazeOptics& optics, const HazeRange& range, const glm::dvec3& airlight,
                   DiffusionScheme scheme) {
  HazeLook look;
  look.weight = optics.weight;
  look.extinction = optics.extinction;
  look.airlight = airlight;
  look.inner_px = optics.inner_px;
  look.widening_px = optics.sigma_px(1.0) - optics.inner_px;
  const auto farthest = range.range.empty() ? 0.0F : *std::ranges::max_element(range.range.elements());
  const double widest = optics.sigma_px(static_cast<double>(farthest));
  if (scheme == DiffusionScheme::explicit_steps)
    look.explicit_passes = passes_of(scheme, optics.inner_px, widest);
  else
    for (const auto& pass : matched_passes(optics.inner_px, widest))
      look.passes.push_back({static_cast<double>(pass.offset_px), pass.from_px2, pass.variance_px2});
  look.same_surface = static_cast<double>(kSameSurface / kRangeStepTurn);
  look.other_surface = static_cast<double>(kOtherSurface / kRangeStepTurn);
  return look;
}

}  // namespace kasumi
