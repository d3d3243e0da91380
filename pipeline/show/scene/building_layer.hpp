// The building's layer: when it is drawn again, at once or in slices between the pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "gles/composite/renderer.hpp"
#include "pipeline/show/scene/layer_light.hpp"

namespace kasumi {

// The layer of an earlier start, shown until this one has drawn its own. It is drawn from the model, under the light and
// air that were known then; it has no pixel of a camera's.
struct LayerOfBefore {
  KeptLayer layer;
  SunDirection sun{0, 0, 1};
  double turbidity = 1.0;
  double near_ground = 1.0;  // as AirState has it
  double past_hills = 1.0;   // as SceneConditions has it
};

// Belongs to the renderer that it is always given.
class BuildingLayer {
 public:
  // Draws what is missing under these conditions. Errors: device.
  Result<> update_at_once(Renderer& renderer, const SceneAir& air, const LayerConditions& now);
  // The first, as soon as can be: the layer of before, where it may stand for it, or with a coarser shadow where GL is
  // software. update_in_slices() then draws it anew, within five seconds. `captured_at`: of the picture. Errors: device.
  Result<> update_soon(Renderer& renderer, const SceneAir& air, const LayerConditions& now, Instant captured_at);
  // As update_at_once() in an eighth of the time between two pictures, by `clock`, while the old layer is shown; in a
  // third of it where that is of update_soon(). Somebody else computes its light and air. One layer at a time: asked for,
  // answered, drawn, and then the next that is due. Needs a layer. Errors: device.
  Result<> update_in_slices(Renderer& renderer, const SceneAir& air, const LayerConditions& now, Instant captured_at,
                            const Clock& clock);
  // For update_soon().
  void offer(LayerOfBefore before) { before_ = std::move(before); }
  bool is_at_hand(const SceneConditions& now) const;
  // The cached layer for another start; empty: it cannot be kept, or is to be replaced soon.
  std::optional<LayerOfBefore> to_keep(const Renderer& renderer) const;

  std::optional<LayerQuestion> take_question() { return std::exchange(question_, std::nullopt); }
  void adopt(LayerAnswer answer);  // one to another question than the last is left

  // The pieces of update_at_once(). go_on(): true: it is drawn.
  Result<> fit(Renderer& renderer, const ObjectDetail& wanted);
  Result<> begin(Renderer& renderer, const LayerConditions& under, ObjectAppearance appearance,
                 const WithLayer& with = {});
  Result<bool> go_on(Renderer& renderer, const std::function<bool()>& time_is_left = {});

  bool any() const { return layer_.has_value(); }
  BuildingView view() const { return layer_ ? layer_->scene.view : BuildingView::live; }  // as alone is
  std::uint64_t drawn() const { return drawn_; }                                          // layers so far
  const ObjectDetail& detail() const { return detail_; }
  // Of the layer begun last; null: none was.
  const std::shared_ptr<const ObjectAppearance>& appearance() const { return appearance_; }
  // The same where it still holds, else that of now, the ground left out.
  const std::shared_ptr<const ObjectAppearance>& appearance_at(const SceneConditions& now, const SceneAir& air,
                                                               const PixelBox& box);

 private:
  bool is_as(const LayerConditions& now) const;
  Result<> draw_at_once(Renderer& renderer, const SceneAir& air, const LayerConditions& now, bool soon);
  bool show_before(Renderer& renderer, const LayerConditions& now);
  void ask(const Renderer& renderer, const SceneAir& air, const LayerConditions& now, Instant captured_at);

  ObjectDetail detail_;                                 // of the renderer
  std::optional<LayerConditions> layer_, unfinished_;   // what the cached layer was drawn under, and the next one is
  std::shared_ptr<const ObjectAppearance> appearance_;  // of the layer begun last
  bool provisional_ = false;                            // the cached layer: its shadow is coarse, or it is of before
  std::optional<LayerOfBefore> before_;                 // until the first layer
  std::uint64_t drawn_ = 0;
  std::optional<Instant> last_;  // when the last picture was captured
  struct Asked {
    std::shared_ptr<const SceneAir> air;  // of the question
    Instant at;                           // when its picture was captured
  };
  std::optional<Asked> asked_;             // not yet answered
  std::optional<LayerQuestion> question_;  // not yet taken
  std::optional<LayerAnswer> answer_;      // not yet begun
};

}  // namespace kasumi
