// A desktop window with a GLES 2 context (SDL2), for previewing what the kiosk shows.
#pragma once

#include <memory>
#include <string>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

struct WindowSpec {
  std::string title = "Kasumi";
  int width = 1280;
  int height = 720;
  bool wait_for_refresh = true;  // show() waits for the display's refresh
};

// User input since the last call.
struct WindowInput {
  bool dragging = false;  // the left button is down
  double x_px = 0.0;      // pointer position in pixels from the window's top left
  double y_px = 0.0;
  std::string keys;  // letters and digits pressed, in their order; '<' '>' '^' 'v' for the arrows
};

class Window : public GlContext {
 public:
  virtual DrawTarget target() const = 0;  // the window's pixels as they are now: it may be resized at any time
  // Processes user input. false once the window should close (its button, Escape or Q).
  virtual bool handle_events() = 0;
  virtual WindowInput take_input() = 0;
  // BLOCKS until the display accepts the picture if wait_for_refresh is set.
  virtual void show() = 0;
};

// Errors: unsupported when there is no display or it gives no GLES 2 context.
Result<std::unique_ptr<Window>> open_window(const WindowSpec& options);

}  // namespace kasumi
