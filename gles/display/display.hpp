// What the visitor looks at. A display belongs to the thread that opened it, and so does its GL context.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

// One picture that has reached the glass.
struct Flip {
  std::uint64_t number = 0;  // what show() answered
  Instant at{};              // by the display's clock: the first line of the picture left then
};

// What happened underneath since the display was opened.
struct DisplayCounts {
  std::uint64_t flips = 0;
  std::uint64_t flip_timeouts = 0;  // flips that did not complete within flip_deadline
  std::uint64_t modesets = 0;       // the first one included
};

class Display {
 public:
  virtual ~Display() = default;
  virtual std::string description() const = 0;  // "card0 HDMI-A-1 1920x1080 at 60.0 Hz, atomic"
  virtual GlContext& context() = 0;

  // BLOCKS until there is a buffer to draw into, or the deadline passes. The context is current then.
  // Errors: timeout (a flip has not completed; later calls may succeed), disconnected (connector, mode or master gone:
  // open the display anew), end_of_stream (the person closed the window), device (the context is lost, or the driver
  // refuses: open the display and everything under its context anew).
  virtual Result<DrawTarget> begin(Instant deadline) = 0;
  // Queues what was drawn since begin() for the display's next refresh; answers its number. `until_replaced` is held
  // until the flip that replaces this picture has completed. Errors: disconnected, device.
  virtual Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced = nullptr) = 0;
  // The flips that completed since the last call, oldest first. Does not block.
  virtual std::vector<Flip> take_flips() = 0;
  virtual DisplayCounts counts() const { return {}; }
  // Turns the screen off; the next picture turns it on again. BLOCKS in the driver. Errors: unsupported (it stays on:
  // show black), timeout (a picture is still on its way: try again), device.
  virtual Result<> turn_off() { return fail(FaultKind::unsupported, "{} cannot be turned off", description()); }
};

// Hears of displays that come and go, so that nobody has to wait out a pause before looking again.
class DisplayWatch {
 public:
  virtual ~DisplayWatch() = default;
  virtual bool take_change() = 0;  // whether something changed since the last call. Does not block
};
// Error: unsupported (no udev).
Result<std::unique_ptr<DisplayWatch>> watch_displays();

// A framebuffer nobody sees, for tests and machines without a display. Flips complete at once.
struct HeadlessDisplayOptions {
  int width = 1280;
  int height = 720;
  friend bool operator==(const HeadlessDisplayOptions&, const HeadlessDisplayOptions&) = default;
};
class HeadlessDisplay;
Result<std::unique_ptr<HeadlessDisplay>> open_headless_display(const HeadlessDisplayOptions& options, Clock& clock);

// The desk window.
struct WindowDisplayOptions {
  std::string title = "Kasumi";
  int width = 1280;
  int height = 720;
  friend bool operator==(const WindowDisplayOptions&, const WindowDisplayOptions&) = default;
};
Result<std::unique_ptr<Display>> open_window_display(const WindowDisplayOptions& options, Clock& clock);

// The whole screen through the kernel's modesetting, without a display server. There is no virtual terminal to switch:
// the service runs without one, and the console draws nothing while we are DRM master. Who must have a terminal's
// switches obeyed runs a display server and takes the window.
struct KmsDisplayOptions {
  std::string device;     // "/dev/dri/by-path/pci-0000:00:02.0-card"; empty: the first card with a connected connector
  std::string connector;  // like "HDMI-A-1"; empty: the first connected one
  int width = 0;          // of the mode; 0: the display's preferred one
  int height = 0;
  double refresh_hz = 0.0;         // 0: the highest of that size
  bool preferred_instead = false;  // a mode the display does not offer: take its preferred one instead, and say so in
                                   // description()
  bool atomic = true;              // false: the legacy calls although the driver has atomic ones
  Duration flip_deadline = std::chrono::seconds(1);
  friend bool operator==(const KmsDisplayOptions&, const KmsDisplayOptions&) = default;
};
// The first picture sets the mode (BLOCKS in the driver, which gives up after about 10 s at worst); closing gives the
// screen back to what it showed before.
// Errors: disconnected (no card, no connected connector, no modes: try again), bad_input (no connector or mode of that
// name; what there is), device (EBUSY or EACCES: somebody else is DRM master, and who where that is known),
// unsupported.
Result<std::unique_ptr<Display>> open_kms_display(const KmsDisplayOptions& options, Clock& clock);

}  // namespace kasumi
