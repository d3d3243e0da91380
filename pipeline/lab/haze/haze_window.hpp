// The desktop window of `kasumi haze --live`: keys change the haze.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "gles/air/haze_blur.hpp"
#include "gles/display/window.hpp"
#include "pipeline/lab/haze/haze_options.hpp"

namespace kasumi {

// A and Z: more or less absorption; S and X: scattering (T itself when given as a turbidity); D and C: lambda; R: back
// to the given values. Other keys are ignored. Returns whether anything changed.
bool adjust_haze(HazeValues& haze, const HazeValues& given, char key);
// "kappa_a .25 (A, Z)   kappa_s .25 (S, X)   lambda 15 (D, C)".
std::string caption_of(const HazeValues& haze);

class HazeWindow {
 public:
  // `task` must outlive it. Errors: unsupported (no display), device.
  static Result<HazeWindow> open(const HazeTask& task);
  // Handles pressed keys, and those in `more` as if pressed; draws and presents. Returns false when the window is to
  // close.
  // BLOCKS until the display takes the picture. Errors: device, bad_input (a blur larger than the picture).
  Result<bool> step(const std::string& more = {});
  const HazeValues& values() const { return haze_; }
  DrawTarget target() const { return window_->target(); }

 private:
  HazeWindow(const HazeTask& task, std::unique_ptr<Window> window, HazeBlur blur)
      : task_(&task), window_(std::move(window)), blur_(std::move(blur)), haze_(task.values.front()) {}
  const HazeTask* task_;
  std::unique_ptr<Window> window_;  // destroyed after the objects created in it
  HazeBlur blur_;
  HazeValues haze_;
  bool changed_ = true;
  std::string problem_;  // why the last change could not be applied
};

}  // namespace kasumi
