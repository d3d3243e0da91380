#include "pipeline/lab/photographs/learn_cameras.hpp"

#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "pipeline/machine/ordered_jobs.hpp"

namespace kasumi {
namespace {

// The answers to some pictures, in their order; each thread keeps what it knows of each camera.
template <class Answer>
std::vector<Answer> ask(const std::vector<EstimateInput>& pictures, const std::vector<PhotographSetup>& cameras,
                        std::size_t threads,
                        const std::function<Answer(PhotographEstimator&, const EstimateInput&)>& question) {
  std::vector<std::map<std::size_t, PhotographEstimator>> photographs(threads);
  std::vector<Answer> answers;
  std::size_t given = 0;
  run_in_order<EstimateInput, Answer>(
      threads, [&]() { return given < pictures.size() ? std::optional(pictures[given++]) : std::nullopt; },
      [&](std::size_t worker, const EstimateInput& picture) {
        auto& own = photographs[worker].try_emplace(picture.camera, cameras[picture.camera]).first->second;
        return question(own, picture);
      },
      [&](const EstimateInput&, const Answer& answer) { answers.push_back(answer); });
  return answers;
}

std::optional<CameraSight> sight_of(PhotographEstimator& photographs, const EstimateInput& picture) {
  const auto report = photographs.estimate_from(picture.file, picture.utc);
  if (!report || !report->camera_circle.found) return std::nullopt;
  CameraSight sight{picture.file, report->camera_circle, std::nullopt, std::nullopt};
  if (report->look.estimate.usable && report->look.tone_exponent > 0.0)
    sight.tone = ToneSight{report->look.tone_exponent, report->look.sigma_tone_exponent};
  if (report->sun.seen && report->sun.by_time_and_place)
    sight.sun = SunPair{report->sun.seen->direction, *report->sun.by_time_and_place};
  return sight;
}

std::vector<EstimateInput> spread(const std::vector<EstimateInput>& pictures, std::size_t most) {
  const std::size_t step = (pictures.size() + most - 1) / most;
  std::vector<EstimateInput> some;
  for (std::size_t i = 0; i < pictures.size(); i += step) some.push_back(pictures[i]);
  return some;
}

}  // namespace

std::shared_ptr<const CameraMemory> learn_cameras(const std::vector<EstimateInput>& pictures,
                                                  const std::vector<PhotographSetup>& cameras, CameraMemory before,
                                                  bool kept, std::size_t threads, std::size_t most_asked) {
  std::vector<EstimateInput> strange;  // of cameras that are not calibrated
  for (const EstimateInput& picture : pictures)
    if (picture.problem.empty() && !cameras[picture.camera].calibrated) strange.push_back(picture);
  auto memory = std::make_shared<CameraMemory>(std::move(before));
  if (strange.empty() || (strange.size() == 1 && !kept)) return memory;

  const auto circles = ask<std::optional<SizedCircle>>(
      strange, cameras, threads, [](PhotographEstimator& photographs, const EstimateInput& picture) {
        const auto circle = photographs.circle_in(picture.file);
        return circle ? std::optional(*circle) : std::nullopt;
      });
  std::map<std::filesystem::path, SizedCircle> found;
  for (std::size_t i = 0; i < strange.size(); ++i)
    if (circles[i]) found.emplace(strange[i].file, *circles[i]);
  memory->learn_circles(found);

  std::vector<PhotographSetup> with_circles = cameras;
  for (auto& camera : with_circles) {
    camera.memory = std::make_shared<CameraMemory>(memory->without_turns());
    camera.azimuth_up.reset();
  }
  std::vector<EstimateInput> known;  // of a camera that several pictures show, or that later calls may see again
  for (const EstimateInput& picture : strange)
    if (const auto* circle = memory->found_in(picture.file)) {
      const auto of_camera = memory->circle_of(*circle);
      if (!of_camera) continue;
      const auto& [width, height, _] = *circle;
      const bool useful = kept ? memory->knows(width, height, of_camera->circle)
                               : memory->camera_of(width, height, of_camera->circle) != nullptr;
      if (useful) known.push_back(picture);
    }
  if (known.empty()) return memory;
  std::vector<CameraSight> sights;
  for (auto& sight : ask<std::optional<CameraSight>>(spread(known, most_asked), with_circles, threads, sight_of))
    if (sight) sights.push_back(std::move(*sight));
  auto learned = std::make_shared<CameraMemory>(*memory);
  learned->learn(sights);
  return learned;
}

}  // namespace kasumi
