// The cost of keeping people in front of the building: detection in each picture on the processor, and drawing around
// them.
#include "estimator/passers/passers.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

namespace kasumi {
namespace {

constexpr int kAround_px = 32;  // as the compositor looks around a building
constexpr int kWide_px = 60, kHigh_px = 160;
constexpr int kPicturePairs = 21, kLooks = 15;

// A dark stripe of the size of a person at the foot of the box.
BenchFrame with_somebody(BenchFrame frame, const PixelBox& box) {
  const int left = (box.left + box.right - kWide_px) / 2, top = box.bottom - kHigh_px;
  for (int y = top; y < top + kHigh_px; ++y)
    for (int x = left; x < left + kWide_px; ++x)
      frame.luma[static_cast<std::size_t>(y) * frame.pixels.width() + static_cast<std::size_t>(x)] = 40;
  return frame;
}

// Looks at pictures 30 times a second.
class Watch {
 public:
  explicit Watch(const PartPlace& place) : passers_(place) {}
  const PassersLook& look(const PictureView& picture, Duration later = std::chrono::milliseconds(33)) {
    return passers_.look(picture, now_ += later);
  }
  // Until the scene without people is learnt. False: it still is not.
  bool learn(const PictureView& empty) {
    for (int second = 0; second < 300 && passers_.last().state != PassersState::watching; ++second)
      look(empty, std::chrono::seconds(1));
    return passers_.last().state == PassersState::watching;
  }

 private:
  Passers passers_;
  Instant now_{};
};

}  // namespace

Result<std::vector<BenchRow>> bench_people() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create((*context)->info(), scene.view.width, scene.view.height);
  if (!offscreen) return fail(offscreen.error());
  auto renderer = drawn_by_renderer(**context, scene);
  if (!renderer) return fail(renderer.error());

  const PixelBox box = renderer->object_box();
  const PartPlace place =
      part_around(box.left, box.top, box.right, box.bottom, kAround_px, scene.view.width, scene.view.height);
  const BenchFrame somebody = with_somebody(scene.frame, box);
  Watch watch(place);
  if (!watch.learn(scene.frame.nv12()))
    return fail(FaultKind::unsupported, "people before the building: nothing is learnt");

  bool found = false, false_find = false;
  const auto without = [&](const BenchFrame& frame) {
    return [&]() -> Result<> {
      if (auto loaded = renderer->upload(frame.nv12()); !loaded) return loaded;
      if (auto set = renderer->set_in_front({}); !set) return set;
      return renderer->draw(scene.measured, offscreen->target());
    };
  };
  const auto with = [&](const BenchFrame& frame, bool& anybody) {
    return [&]() -> Result<> {
      if (auto loaded = renderer->upload(frame.nv12()); !loaded) return loaded;
      const PassersInFront& in_front = watch.look(frame.nv12()).in_front;
      anybody = anybody || !in_front.empty();
      if (auto set = renderer->set_in_front({in_front.left, in_front.top, in_front.pixels}); !set) return set;
      return renderer->draw(scene.measured, offscreen->target());
    };
  };
  Stopwatch stopwatch;
  const double nobody_ratio = stopwatch.ratio(with(scene.frame, false_find), without(scene.frame), kPicturePairs);
  const double look_s = least_seconds_of([&] { watch.look(scene.frame.nv12()); }, kLooks);
  const double somebody_ratio = stopwatch.ratio(with(somebody, found), without(somebody), kPicturePairs);
  if (!stopwatch.result()) return fail(stopwatch.result().error());
  if (!found || false_find)
    return fail(FaultKind::unsupported, "people before the building: {}",
                found ? "a person is found where there is none" : "a person is not found");
  return std::vector<BenchRow>{
      {.name = "picture (NV12) with people_in_front, nobody there / without", .value = nobody_ratio, .goal = {}},
      {.name = fmt::format("  somebody of {} x {} pixels there / without", kWide_px, kHigh_px),
       .value = somebody_ratio,
       .goal = {}},
      {.name = fmt::format("  looking at a part of {} x {} pixels", place.width, place.height),
       .value = 1e3 * look_s,
       .unit = "ms",
       .goal = {}}};
}

}  // namespace kasumi
