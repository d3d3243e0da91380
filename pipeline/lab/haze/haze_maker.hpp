// Hazy pictures, rendered on the GPU or by the CPU reference.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "gles/air/haze_blur.hpp"
#include "pipeline/lab/haze/haze_options.hpp"

namespace kasumi {

// What HazeMaker renders: the picture, and the work of its blur.
struct RenderedHaze {
  Photograph picture;
  DiffusionCost cost;
};

class HazeMaker {
 public:
  // `task` must outlive it. The invariant scheme runs on the CPU only: it interpolates between pixels, which GLES 2
  // does not filter. Falls back to the CPU when there is no GL; device() says which is used. Errors: device.
  static Result<HazeMaker> create(const HazeTask& task, bool on_cpu);
  Result<RenderedHaze> make(const HazeValues& haze);
  const std::string& device() const { return device_; }  // "the CPU", "llvmpipe (...), half floats"

 private:
  explicit HazeMaker(const HazeTask& task) : task_(&task) {}
  const HazeTask* task_;
  std::string device_ = "the CPU";
  std::unique_ptr<GlContext> context_;  // destroyed after the objects created in it
  std::optional<HazeBlur> blur_;
};

}  // namespace kasumi
