// Light and air of a layer. Computing them takes longer than a picture lasts, so it can be done apart: by anybody, in
// any thread.
#pragma once

#include <memory>

#include "gles/light/sky_squares.hpp"
#include "gles/scene.hpp"
#include "pipeline/show/scene/ground_watch.hpp"
#include "pipeline/show/scene/scene_air.hpp"

namespace kasumi {

// What whoever draws asks of whoever computes.
struct LayerQuestion {
  std::shared_ptr<const SceneAir> air;  // of then; nobody else uses it until the answer
  SceneConditions conditions;
  ObjectDetail detail;  // of the layer
  PixelBox box;         // where the object appears with it
  bool mirrors = false;
  GroundLook ground;
};
struct LayerAnswer {
  std::shared_ptr<const SceneAir> air;  // of the question
  SceneConditions conditions;
  ObjectDetail detail;
  ObjectAppearance appearance;
  std::shared_ptr<const SkySquares> sky;
  GroundLook ground;
};
LayerAnswer answer(const LayerQuestion& question);

}  // namespace kasumi
