// Makes a stage in pieces of some milliseconds, so that a stage in the same GL context can go on drawing in between; and
// finds out whether content can be drawn at all.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor_making.hpp"
#include "pipeline/show/stage/stage.hpp"

namespace kasumi {

// What a stage needs and takes long to compute, made without GL, on any thread.
struct PreparedStage {
  CompositorInputs scene;
  std::optional<FlatTexels> still;
};
std::shared_ptr<const PreparedStage> prepare_stage(const Content& content);

// Bytes that the content's stage takes beside the content itself, while it is prepared and then on the GPU. On software
// GL, and where GPU and processor share their memory, both are the machine's.
std::uint64_t bytes_to_stage(const Content& content);

// A first picture drawn off screen: content that GL refuses fails then, and the building is ready when the first frame
// comes.
struct Rehearsal {
  SkyReport sky{};                         // where the sun is not known, an ordinary noon is taken
  PixelLayout layout = PixelLayout::rgb8;  // of the camera's pictures
  int target_width = 1280, target_height = 720;
  BuildingView view{};
};

// Belongs to the thread of its GL context, which must be current in every call.
class StageMaking {
 public:
  // `prepared`: null: made here. `air`: of an earlier stage of this content. Errors: those of step().
  static Result<StageMaking> begin(GlContext& context, ContentPtr content,
                                   std::shared_ptr<const PreparedStage> prepared = nullptr,
                                   std::optional<SceneAir> air = std::nullopt,
                                   std::optional<Rehearsal> rehearsal = std::nullopt);
  // true: the stage is whole. The GPU has done its part when this returns. Errors: bad_input (too large for this GL, a
  // lens that folds), device (memory, shaders), unsupported.
  Result<bool> step();
  Stage take() { return std::move(*stage_); }

 private:
  enum class Part { scene, still, layer, picture, words, whole };
  StageMaking(GlContext& context, ContentPtr content, std::shared_ptr<const PreparedStage> prepared,
              CompositorMaking scene, std::optional<Rehearsal> rehearsal)
      : context_(&context),
        content_(std::move(content)),
        prepared_(std::move(prepared)),
        scene_(std::move(scene)),
        rehearsal_(std::move(rehearsal)) {}
  Result<Part> next();
  Result<Part> make_stage();
  Result<Part> rehearse_picture();
  Result<Part> rehearse_words();

  GlContext* context_;
  ContentPtr content_;
  std::shared_ptr<const PreparedStage> prepared_;
  CompositorMaking scene_;
  std::optional<Rehearsal> rehearsal_;
  std::optional<Stage> stage_;
  std::optional<Offscreen> unseen_;  // what the rehearsal draws on
  Part part_ = Part::scene;
};

// Draws it under a GL context of its own, without a screen. Errors: unsupported (no such context here); else why it
// cannot be drawn. `renderer`: what drew it.
Result<> try_drawing(const ContentPtr& content, std::shared_ptr<const PreparedStage> prepared, std::string& renderer);

}  // namespace kasumi
