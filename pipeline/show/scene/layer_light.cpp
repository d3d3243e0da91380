#include "pipeline/show/scene/layer_light.hpp"

namespace kasumi {

LayerAnswer answer(const LayerQuestion& question) {
  const LayerConditions& under = question.under;
  LayerAnswer made{question.air, under, question.air->appearance(under.scene, question.box, under.ground), nullptr};
  made.sky = std::make_shared<const AtlasSquares>(atlas_squares(made.appearance.light.around, question.mirrors));
  return made;
}

}  // namespace kasumi
