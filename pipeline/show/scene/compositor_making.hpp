// What a compositor is made of, and its making in pieces.
#pragma once

#include <memory>
#include <utility>

#include "gles/gpu_model/triangle_chunks.hpp"
#include "pipeline/show/scene/compositor.hpp"

namespace kasumi {

// What a compositor needs beside the installation and takes long to compute, made without GL.
struct CompositorInputs {
  TriangleChunks chunks;
  Image<float> depth_m;                 // as depth_for_gles()
  std::shared_ptr<GroundWatch> ground;  // null: there is none to be seen, or no shadow on it
};
CompositorInputs prepare_scene(const Installation& installation, const Model& model);

// Makes a compositor in pieces of some milliseconds, between which others may draw under the same context.
class CompositorMaking {
 public:
  // All references must outlive it; `prepared`: null: made here. Errors: as Compositor::create().
  static Result<CompositorMaking> begin(GlContext& context, const Installation& installation, const Model& model,
                                        std::shared_ptr<const CompositorInputs> prepared, SceneAir air,
                                        const RendererOptions& renderer = {});
  // true: it is whole. Errors: as Compositor::create().
  Result<bool> step();
  Compositor take() { return std::move(made_); }

 private:
  CompositorMaking(Compositor made, const Installation& installation, const Model& model,
                   std::shared_ptr<const CompositorInputs> prepared)
      : made_(std::move(made)), installation_(&installation), model_(&model), prepared_(std::move(prepared)) {}
  Result<> set_scene();

  Compositor made_;
  const Installation* installation_;
  const Model* model_;
  std::shared_ptr<const CompositorInputs> prepared_;
};

}  // namespace kasumi
