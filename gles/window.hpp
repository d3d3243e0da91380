// A desk window with a GLES 2 context (SDL2), for looking at what the kiosk will show.
#pragma once

#include <memory>
#include <string>

#include "base/result.hpp"
#include "gles/context.hpp"
#include "gles/target.hpp"

namespace kasumi {

struct WindowOptions {
  std::string title = "Kasumi";
  int width = 1280;
  int height = 720;
  bool wait_for_refresh = true;  // show() waits for the display's refresh
};

class Window : public GlContext {
 public:
  virtual DrawTarget target() const = 0;  // the window's pixels as they are now: it may be resized at any time
  // Takes in what the person did. false once the window is to be closed (its button, Escape or Q).
  virtual bool handle_events() = 0;
  // BLOCKS until the display takes the picture when wait_for_refresh is set.
  virtual void show() = 0;
};

// Errors: unsupported when there is no display or it gives no GLES 2 context.
Result<std::unique_ptr<Window>> open_window(const WindowOptions& options);

}  // namespace kasumi
