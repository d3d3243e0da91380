// The desktop window of `kasumi sky`: drag the sun, change turbidity and altitude, look around.
#pragma once

#include <string>

#include "gles/display/window.hpp"
#include "pipeline/lab/sky/sky_options.hpp"

namespace kasumi {

// What the window shows; user input changes it.
struct SkyWindowState {
  Viewpoint camera;
  DomeRequest sky;
  bool mountains = false;

  // Applies the pointer (in pixels of the picture) and keys. Returns whether anything changed.
  bool apply(const WindowInput& input);
  // "T 2.5   altitude 0 m   sun 45.0 deg from the zenith, azimuth 180.0 deg".
  std::string caption() const;
};

// BLOCKS until the window is closed. Errors: unsupported (no display), device.
Result<> show_sky_window(const DrawingTask& task);

}  // namespace kasumi
