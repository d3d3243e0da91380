#include "pipeline/show/scene/building_layer.hpp"

#include <algorithm>
#include <cmath>

#include <spdlog/spdlog.h>

#include "base/geometry.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

namespace {

constexpr Duration kSlice = std::chrono::milliseconds(4);  // of a picture's time, at least
constexpr int kSlices = 8;                                 // an eighth of the time between two pictures, if longer
constexpr Duration kLongestSlice = std::chrono::milliseconds(125);  // even then: visitors press keys meanwhile
// The same where a layer has to be replaced soon: at one picture a second, too, 1.3 s within five.
constexpr int kSoonSlices = 3;
constexpr Duration kLongestSoonSlice = std::chrono::milliseconds(333);
constexpr Duration kAnswerBound = std::chrono::seconds(20);  // give up on a worker that has not answered

// Between the layer of before and what would be drawn. Within these it is less than a step of 255 off by the mean over
// the object's pixels, and a shadow's edge is where it was four minutes ago. Clouds are those of then.
constexpr Radians kMostSunMove = from_degrees(1.0);
constexpr double kMostHazeChange = 0.03;      // a sky measured twice differs by as much
constexpr double kMostHillsChange = 0.1;      // of the sun's disc
constexpr double kMostSpreadChange_px = 0.1;  // by the haze before the object

bool is_near(double now, double then, double share) {
  return std::abs(now - then) <= share * then;
}

bool may_stand_for(const LayerOfBefore& before, const SceneConditions& now) {
  return now.view == BuildingView::live && angle_between(now.sun, before.sun) <= kMostSunMove &&
         is_near(now.air.turbidity().value - 1.0, before.turbidity - 1.0, kMostHazeChange) &&
         is_near(now.air.near_ground(), before.near_ground, kMostHazeChange) &&
         std::abs(now.past_hills - before.past_hills) <= kMostHillsChange;
}

bool is_near(ObjectDetail one, const ObjectDetail& other) {
  if (std::abs(one.point_spread_px - other.point_spread_px) > kMostSpreadChange_px) return false;
  one.point_spread_px = other.point_spread_px;
  return one == other;
}

}  // namespace

bool BuildingLayer::is_as(const LayerConditions& now) const {
  return layer_ && look_alike(now.scene, layer_->scene) && look_alike(now.ground, layer_->ground);
}

bool BuildingLayer::is_at_hand(const SceneConditions& now) const {
  return layer_ || (before_ && may_stand_for(*before_, now));
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
  provisional_ = renderer.has_coarse_shadow();
  before_.reset();
  detail_ = layer_->detail;
  ++drawn_;
  return true;
}

Result<> BuildingLayer::update_at_once(Renderer& renderer, const SceneAir& air, const LayerConditions& now) {
  return draw_at_once(renderer, air, now, false);
}

Result<> BuildingLayer::update_soon(Renderer& renderer, const SceneAir& air, const LayerConditions& now,
                                    Instant captured_at) {
  if (!show_before(renderer, now))
    if (auto drawn = draw_at_once(renderer, air, now, true); !drawn) return drawn;
  last_ = captured_at;
  if (provisional_) ask(renderer, air, now, captured_at);
  return {};
}

// One that the renderer refuses is drawn instead.
bool BuildingLayer::show_before(Renderer& renderer, const LayerConditions& now) {
  const auto before = std::exchange(before_, std::nullopt);
  if (!before || unfinished_ || !may_stand_for(*before, now.scene) || !is_near(before->layer.detail, now.detail))
    return false;
  if (auto restored = renderer.restore_layer(before->layer); !restored) {
    spdlog::info("the building's layer of before is not shown: {}", restored.error().message);
    return false;
  }
  spdlog::info("the building is shown as it was drawn before the start, until it is drawn anew");
  layer_ = now;
  layer_->detail = detail_ = before->layer.detail;
  provisional_ = true;
  ++drawn_;
  return true;
}

std::optional<LayerOfBefore> BuildingLayer::to_keep(const Renderer& renderer) const {
  if (!layer_ || provisional_ || layer_->scene.view != BuildingView::live) return std::nullopt;
  auto kept = renderer.layer_to_keep();
  if (!kept) return std::nullopt;
  const auto& under = layer_->scene;
  return LayerOfBefore{std::move(*kept), under.sun, under.air.turbidity().value, under.air.near_ground(),
                       under.past_hills};
}

Result<> BuildingLayer::draw_at_once(Renderer& renderer, const SceneAir& air, const LayerConditions& now, bool soon) {
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
    release_compiler();  // pictures since the layer before may have needed it
    const auto answer = std::exchange(answer_, std::nullopt);
    if (auto begun = begin(renderer, answer->under, answer->appearance, {answer->under.detail, answer->sky}); !begun)
      return begun;
  }
  const auto apart = captured_at - std::exchange(last_, captured_at).value_or(captured_at);
  if (unfinished_) {
    const auto began = clock.now();
    const auto slice = provisional_ ? std::clamp<Duration>(apart / kSoonSlices, kSlice, kLongestSoonSlice)
                                    : std::clamp<Duration>(apart / kSlices, kSlice, kLongestSlice);
    if (const auto whole = go_on(renderer, [&] { return clock.now() - began < slice; }); !whole)
      return fail(whole.error());
  }
  if (!unfinished_ && !asked_ && (now.detail != detail_ || provisional_ || !is_as(now)))
    ask(renderer, air, now, captured_at);
  return {};
}

void BuildingLayer::ask(const Renderer& renderer, const SceneAir& air, const LayerConditions& now,
                        Instant captured_at) {
  const auto of_now = std::make_shared<const SceneAir>(air);
  question_ = LayerQuestion{of_now, now, renderer.object_box(now.detail), renderer.reflects()};
  asked_ = Asked{of_now, captured_at};
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
