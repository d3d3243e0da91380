#include "pipeline/show/scene/building_layer.hpp"

#include <algorithm>

namespace kasumi {

namespace {

constexpr Duration kSlice = std::chrono::milliseconds(4);  // of a picture's time, at least
constexpr int kSlices = 8;                                 // an eighth of the time between two pictures, if longer
constexpr Duration kLongestSlice = std::chrono::milliseconds(125);  // even then: visitors press keys meanwhile
constexpr Duration kAnswerBound = std::chrono::seconds(20);         // give up on a worker that has not answered

}  // namespace

bool BuildingLayer::is_as(const LayerConditions& now) const {
  return layer_ && look_alike(now.scene, layer_->scene) && look_alike(now.ground, layer_->ground);
}

// Rarely does anything: the layout is known from the first frame on, and the air changes within hours.
Result<> BuildingLayer::fit(Renderer& renderer, const ObjectDetail& wanted) {
  if (wanted == detail_) return {};
  if (auto set = renderer.set_detail(wanted); !set) return set;
  detail_ = wanted;
  layer_.reset();
  unfinished_.reset();
  return {};
}

Result<> BuildingLayer::begin(Renderer& renderer, const LayerConditions& under, ObjectAppearance appearance,
                              const WithLayer& with) {
  unfinished_.reset();
  if (auto begun = renderer.begin_layer(appearance, with); !begun) return begun;
  appearance_ = std::make_shared<const ObjectAppearance>(std::move(appearance));
  unfinished_ = under;
  return {};
}

Result<bool> BuildingLayer::go_on(Renderer& renderer, const std::function<bool()>& time_is_left) {
  const auto whole = renderer.continue_layer(time_is_left);
  if (!whole) unfinished_.reset();
  if (!whole || !*whole) return whole;
  layer_ = std::exchange(unfinished_, std::nullopt);
  coarse_ = renderer.has_coarse_shadow();
  detail_ = layer_->detail;
  ++drawn_;
  return true;
}

Result<> BuildingLayer::update_at_once(Renderer& renderer, const SceneAir& air, const LayerConditions& now, bool soon) {
  if (auto fitted = fit(renderer, now.detail); !fitted) return fitted;
  if (!unfinished_ && !is_as(now))
    if (auto begun = begin(renderer, now, air.appearance(now.scene, renderer.object_box(), now.ground),
                           {std::nullopt, nullptr, soon});
        !begun)
      return begun;
  while (unfinished_)
    if (const auto whole = go_on(renderer); !whole) return fail(whole.error());
  return {};
}

Result<> BuildingLayer::update_in_slices(Renderer& renderer, const SceneAir& air, const LayerConditions& now,
                                         Instant captured_at, const Clock& clock) {
  const auto age = asked_ ? captured_at - asked_->at : Duration::zero();
  if (age > kAnswerBound || age < Duration::zero()) asked_.reset();
  if (!unfinished_ && answer_) {
    const auto answer = std::exchange(answer_, std::nullopt);
    if (auto begun = begin(renderer, answer->under, answer->appearance, {answer->under.detail, answer->sky}); !begun)
      return begun;
  }
  const auto apart = captured_at - std::exchange(last_, captured_at).value_or(captured_at);
  if (unfinished_) {
    const auto began = clock.now();
    const auto slice = std::clamp<Duration>(apart / kSlices, kSlice, kLongestSlice);
    if (const auto whole = go_on(renderer, [&] { return clock.now() - began < slice; }); !whole)
      return fail(whole.error());
  }
  if (!unfinished_ && !asked_ && (now.detail != detail_ || coarse_ || !is_as(now))) {
    const auto of_now = std::make_shared<const SceneAir>(air);
    question_ = LayerQuestion{of_now, now, renderer.object_box(now.detail), renderer.reflects()};
    asked_ = Asked{of_now, captured_at};
  }
  return {};
}

void BuildingLayer::adopt(LayerAnswer answer) {
  if (!asked_ || answer.air != asked_->air) return;
  asked_.reset();
  answer_ = std::move(answer);
}

const std::shared_ptr<const ObjectAppearance>& BuildingLayer::appearance_at(const SceneConditions& now,
                                                                            const SceneAir& air, const PixelBox& box) {
  if (!(appearance_ && layer_ && look_alike(now, layer_->scene)))
    appearance_ = std::make_shared<const ObjectAppearance>(air.appearance(now, box));
  return appearance_;
}

}  // namespace kasumi
