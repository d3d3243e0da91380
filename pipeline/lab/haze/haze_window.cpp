#include "pipeline/lab/haze/haze_window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/scene/haze_blur_for_gles.hpp"
#include "pipeline/show/stage/caption.hpp"

namespace kasumi {
namespace {

constexpr int kMaxWidth = 1280, kMaxHeight = 900;
constexpr double kFactorPerPress = 1.1892071150027210;  // four presses double the value
constexpr double kSmallestStep = 0.02;                  // below this the value becomes 0

// One step more or less; steps between 0 and `first`.
void adjust(double& value, bool more, double first, double most) {
  if (more)
    value = std::min(std::max(value * kFactorPerPress, first), most);
  else
    value = value <= first * 1.001 ? 0.0 : value / kFactorPerPress;
}

}  // namespace

bool adjust_haze(HazeValues& haze, const HazeValues& given, char key) {
  const auto before = haze;
  switch (key) {
    case 'a':
    case 'z':
      if (!haze.turbidity) adjust(haze.kappa_a, key == 'a', kSmallestStep, 20.0);
      break;
    case 's':
    case 'x':
      if (haze.turbidity)
        haze.turbidity->value = std::clamp(
            haze.turbidity->value * (key == 's' ? std::sqrt(kFactorPerPress) : 1.0 / std::sqrt(kFactorPerPress)),
            kLowestTurbidity.value, kHighestTurbidity.value);
      else
        adjust(haze.kappa_s, key == 's', kSmallestStep, 20.0);
      break;
    case 'd':
    case 'c': adjust(haze.lambda, key == 'd', 1.0, 200.0); break;
    case 'r': haze = given; break;
    default: break;
  }
  return haze.turbidity != before.turbidity || haze.kappa_a != before.kappa_a || haze.kappa_s != before.kappa_s ||
         haze.lambda != before.lambda;
}

std::string caption_of(const HazeValues& haze) {
  if (haze.turbidity && haze.like)
    return fmt::format("AOD {:.3f}, T {:.2f} (S, X)   lambda {:.1f} (D, C)   R: as given",
                       air_of(*haze.turbidity, haze.like).aerosol().aod_550, haze.turbidity->value, haze.lambda);
  if (haze.turbidity)
    return fmt::format("T {:.2f} (S, X)   lambda {:.1f} (D, C)   R: as given", haze.turbidity->value, haze.lambda);
  return fmt::format("kappa_a {:.3f} (A, Z)   kappa_s {:.3f} (S, X)   lambda {:.1f} (D, C)   R: as given", haze.kappa_a,
                     haze.kappa_s, haze.lambda);
}

Result<HazeWindow> HazeWindow::open(const HazeTask& task) {
  const int width = task.light.width(), height = task.light.height();
  const double scale =
      std::min({1.0, static_cast<double>(kMaxWidth) / width, static_cast<double>(kMaxHeight) / height});
  auto window = open_window({"Kasumi: haze", std::max(1, static_cast<int>(std::lround(scale * width))),
                             std::max(1, static_cast<int>(std::lround(scale * height))), true});
  if (!window) return fail(window.error());
  auto blur = HazeBlur::create((*window)->info(), width, height);
  if (!blur) return fail(blur.error());
  if (auto set = blur->set_scene(haze_scene(task.light, task.range)); !set) return fail(set.error());
  return HazeWindow(task, std::move(*window), std::move(*blur));
}

Result<bool> HazeWindow::step(const std::string& more) {
  if (!window_->handle_events()) return false;
  const auto before = haze_;
  for (const char key : window_->take_input().keys + more)
    changed_ = adjust_haze(haze_, task_->values.front(), key) || changed_;
  if (changed_) {
    const auto blur = haze_look(task_->optics_of(haze_), task_->range, task_->airlight, task_->scheme);
    const auto run = blur_.run(blur);
    if (!run && run.error().kind != FaultKind::bad_input) return fail(run.error());
    problem_ = run ? std::string() : "\n" + run.error().message;
    if (!run) haze_ = before;
    changed_ = false;
  }
  const auto target = window_->target();
  if (auto shown = blur_.show(target); !shown) return fail(shown.error());
  CaptionStyle style;
  style.height_px = std::max(14.0, target.height / 40.0);
  style.largest_width_px = std::max(100, target.width - 20);
  const auto words = draw_caption(caption_of(haze_) + problem_, style);
  if (!words) return fail(words.error());
  const auto caption = FlatPicture::create(*window_, *words);
  if (!caption) return fail(caption.error());
  if (auto done = caption->draw(
          target, {10.0, 10.0, static_cast<double>(words->width()), static_cast<double>(words->height())});
      !done)
    return fail(done.error());
  window_->show();
  // Limits the frame rate on displays that do not block until vertical sync.
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return true;
}

}  // namespace kasumi
