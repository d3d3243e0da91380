#include "pipeline/show/scene/layer_light.hpp"

namespace kasumi {

LayerAnswer answer(const LayerQuestion& question) {
  LayerAnswer made{question.air,    question.conditions,
                   question.detail, question.air->appearance(question.conditions, question.box),
                   nullptr,         question.ground};
  light_ground(made.appearance, question.ground);
  made.sky = std::make_shared<const SkySquares>(sky_squares(made.appearance.light.around, question.mirrors));
  return made;
}

}  // namespace kasumi
