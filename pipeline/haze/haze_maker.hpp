// Pictures under haze, made on the GPU or on the CPU's reference.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "gles/air/haze_blur.hpp"
#include "pipeline/haze/haze_options.hpp"

namespace kasumi {

struct HazyPicture {
  Photograph picture;
  DiffusionCost cost;
};

class HazeMaker {
 public:
  // `task` must outlive it. The invariant scheme, whose reads between pixels GLES 2 does not filter, is the CPU's
  // alone. Without a GPU (or what acts as one) the CPU is taken: notes() tells. Errors: device.
  static Result<HazeMaker> create(const HazeTask& task, bool on_cpu);
  Result<HazyPicture> make(const HazeValues& haze);
  const std::string& device() const { return device_; }  // "the CPU", "llvmpipe (...), half floats"

 private:
  explicit HazeMaker(const HazeTask& task) : task_(&task) {}
  const HazeTask* task_;
  std::string device_ = "the CPU";
  std::unique_ptr<GlContext> context_;  // goes after what was made under it
  std::optional<HazeBlur> blur_;
};

}  // namespace kasumi
