#include "pipeline/show/scene/layer_light.hpp"

namespace kasumi {

ObjectAppearance appearance_under(const LayerConditions& under, const SceneAir& air, const PixelBox& box) {
  ObjectAppearance appearance = air.appearance(under.scene, box);
  light_ground(appearance, under.ground);
  return appearance;
}

LayerAnswer answer(const LayerQuestion& question) {
  LayerAnswer made{question.air, question.under, appearance_under(question.under, *question.air, question.box),
                   nullptr};
  made.sky = std::make_shared<const SkySquares>(sky_squares(made.appearance.light.around, question.mirrors));
  return made;
}

}  // namespace kasumi
