// Light and air of a layer. Computing them takes longer than a picture lasts, so it can be done separately, in any
// thread.
#pragma once

#include <memory>

#include "gles/light/atlas_squares.hpp"
#include "gles/scene.hpp"
#include "pipeline/show/scene/ground_watch.hpp"
#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {

// What a layer of the building is drawn under.
struct LayerConditions {
  SceneConditions scene;
  ObjectDetail detail;
  GroundLook ground;
};

// What whoever draws asks of whoever computes.
struct LayerQuestion {
  std::shared_ptr<const SceneAir> air;  // of then; nobody else uses it until the answer
  LayerConditions under;
  PixelBox box;  // where the object appears with that detail
  bool mirrors = false;
};
struct LayerAnswer {
  std::shared_ptr<const SceneAir> air;  // of the question
  LayerConditions under;
  ObjectAppearance appearance;
  std::shared_ptr<const AtlasSquares> sky;
};
LayerAnswer answer(const LayerQuestion& question);

}  // namespace kasumi
