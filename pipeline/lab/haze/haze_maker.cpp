#include "pipeline/lab/haze/haze_maker.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>
#include <glm/common.hpp>

#include "pipeline/show/scene/haze_blur_for_gles.hpp"

namespace kasumi {
namespace {

Photograph encoded_of(const Camera& camera, const Image<glm::vec3>& light, const Photograph& source) {
  Photograph made;
  made.encoded = Image<glm::vec3>(light.width(), light.height());
  made.quantum = source.quantum;
  made.origin = source.origin;
  std::ranges::transform(light.elements(), made.encoded.elements().begin(), [&](const glm::vec3& linear) {
    return glm::clamp(camera.response.to_encoded(glm::dvec3(linear)), 0.0, 1.0);
  });
  return made;
}

}  // namespace

Result<HazeMaker> HazeMaker::create(const HazeTask& task, bool on_cpu) {
  HazeMaker made(task);
  if (on_cpu || task.scheme == DiffusionScheme::invariant) return made;
  auto context = open_headless_context();
  if (!context) {
    spdlog::warn("haze is computed on the CPU: {}", context.error().message);
    return made;
  }
  auto blur = HazeBlur::create((*context)->info(), task.light.width(), task.light.height());
  if (!blur) {
    spdlog::warn("haze is computed on the CPU: {}", blur.error().message);
    return made;
  }
  if (auto set = blur->set_scene(haze_scene(task.light, task.range)); !set) return fail(set.error());
  made.device_ = fmt::format("{}, {}", (*context)->info().renderer, blur->in_bytes() ? "bytes" : "half floats");
  made.context_ = std::move(*context);
  made.blur_ = std::move(*blur);
  return made;
}

Result<RenderedHaze> HazeMaker::make(const HazeValues& haze) {
  const auto optics = task_->optics_of(haze);
  if (!blur_) {
    auto made = under_haze(task_->light, task_->range, optics, task_->airlight, task_->scheme);
    if (!made) return fail(made.error());
    return RenderedHaze{encoded_of(task_->camera, made->light, task_->photograph), made->cost};
  }
  if (auto run = blur_->run(haze_look(optics, task_->range, task_->airlight, task_->scheme)); !run)
    return fail(run.error());
  const auto blurred = blur_->read();
  if (!blurred) return fail(blurred.error());
  const auto farthest = static_cast<double>(*std::ranges::max_element(task_->range.range.elements()));
  return RenderedHaze{encoded_of(task_->camera, composited(*blurred, task_->airlight), task_->photograph),
                      cost_of(task_->scheme, optics.inner_px, optics.sigma_px(farthest))};
}

}  // namespace kasumi
