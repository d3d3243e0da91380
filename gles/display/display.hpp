// The screen that visitors see. A display and its GL context belong to the thread that opened it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"
#include "gles/picture/external_picture.hpp"

namespace kasumi {

// A picture that has reached the screen.
struct Flip {
  std::uint64_t number = 0;  // as returned by show()
  Instant at{};              // when scanout of the picture's first line began, by the display's clock
};

// Driver events since the display was opened.
struct DisplayCounts {
  std::uint64_t flips = 0;
  std::uint64_t flip_timeouts = 0;  // flips that did not complete within flip_deadline
  std::uint64_t modesets = 0;       // including the first
};

// Premultiplied encoded values, which the display lays over the camera's picture without a GPU.
class PlaneBuffer {
 public:
  virtual ~PlaneBuffer() = default;
  virtual DrawTarget target() const = 0;
  virtual std::uint32_t framebuffer() const = 0;  // the card's number for it
};

// The camera's buffer on one of the display's planes, a part of another buffer on the one above.
struct PlaneStack {
  ExternalPicture camera;                         // of the screen's size
  std::shared_ptr<const PlaneBuffer> building{};  // null: only the camera's picture
  int left = 0, top = 0, right = 0, bottom = 0;   // the part of the screen
  int source_left = 0, source_top = 0;            // where that part begins in the buffer
};

class Display {
 public:
  virtual ~Display() = default;
  virtual std::string description() const = 0;  // "card0 HDMI-A-1 1920x1080 at 60.0 Hz, atomic"
  virtual GlContext& context() = 0;

  // BLOCKS until there is a buffer to draw into, or the deadline passes. The context is current then.
  // Errors: timeout (a flip has not completed; later calls may succeed), disconnected (connector, mode or master lost:
  // reopen the display), end_of_stream (the window was closed), device (the context is lost, or the driver refuses:
  // reopen the display and recreate everything under its context).
  virtual Result<DrawTarget> begin(Instant deadline) = 0;
  // Queues what was drawn since begin() for the display's next refresh and returns its number. `until_replaced` is kept
  // until the flip that replaces this picture has completed. Errors: disconnected, device.
  virtual Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced = nullptr) = 0;
  // The same, on planes of the display's own instead of what was drawn since begin(), which stays to be drawn over. The
  // camera's buffer must keep its picture as `until_replaced` is kept. Errors: unsupported (the display refuses it, with
  // its reason; what it shows stays), timeout (the mode is to be set first, by an ordinary picture), and as show().
  virtual Result<std::uint64_t> show_planes(const PlaneStack&, std::shared_ptr<const void> = nullptr) {
    return fail(FaultKind::unsupported, "{} has no planes of its own", description());
  }
  // A buffer for show_planes(), to be gone before the display is. Errors: unsupported, device.
  virtual Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int, int) {
    return fail(FaultKind::unsupported, "{} has no planes of its own", description());
  }
  // The flips that completed since the last call, oldest first. Does not block.
  virtual std::vector<Flip> take_flips() = 0;
  virtual DisplayCounts counts() const { return {}; }
  // Turns the screen off; the next picture turns it on again. BLOCKS in the driver. Errors: unsupported (it stays on:
  // show black), timeout (a flip is still pending: try again), device.
  virtual Result<> turn_off() { return fail(FaultKind::unsupported, "{} cannot be turned off", description()); }
};

// Watches for displays being plugged and unplugged, so that callers can react without waiting for their next poll.
class DisplayWatch {
 public:
  virtual ~DisplayWatch() = default;
  virtual bool take_change() = 0;  // whether something changed since the last call. Does not block
};
// Error: unsupported (no udev).
Result<std::unique_ptr<DisplayWatch>> watch_displays();

// An offscreen framebuffer, for tests and machines without a display. Flips complete at once.
struct HeadlessDisplayOptions {
  int width = 1280;
  int height = 720;
  friend bool operator==(const HeadlessDisplayOptions&, const HeadlessDisplayOptions&) = default;
};
class HeadlessDisplay;
Result<std::unique_ptr<HeadlessDisplay>> open_headless_display(const HeadlessDisplayOptions& options, Clock& clock);

// A window on a desktop.
struct WindowDisplayOptions {
  std::string title = "Kasumi";
  int width = 1280;
  int height = 720;
  friend bool operator==(const WindowDisplayOptions&, const WindowDisplayOptions&) = default;
};
Result<std::unique_ptr<Display>> open_window_display(const WindowDisplayOptions& options, Clock& clock);

// The whole screen through kernel modesetting, without a display server. Virtual terminal switching is not supported:
// the service runs without a terminal, and the console draws nothing while Kasumi is DRM master. If switching is
// needed, use the window under a display server.
struct KmsDisplayOptions {
  std::string device;     // "/dev/dri/by-path/pci-0000:00:02.0-card"; empty: the first card with a connected connector
  std::string connector;  // like "HDMI-A-1"; empty: the first connected one
  int width = 0;          // of the mode; 0: the display's preferred mode
  int height = 0;
  double refresh_hz = 0.0;         // 0: the highest at that size
  bool preferred_instead = false;  // if the display does not offer the mode, use its preferred one, and say so in
                                   // description()
  bool atomic = true;              // false: use the legacy calls even if the driver supports atomic ones
  Duration flip_deadline = std::chrono::seconds(1);
  friend bool operator==(const KmsDisplayOptions&, const KmsDisplayOptions&) = default;
};
// The first picture sets the mode (BLOCKS in the driver, for about 10 s at worst); closing restores what the screen
// showed before.
// Errors: disconnected (no card, no connected connector, no modes: try again), bad_input (no such connector or mode;
// lists those available), device (EBUSY or EACCES: another process is DRM master, named if known), unsupported.
Result<std::unique_ptr<Display>> open_kms_display(const KmsDisplayOptions& options, Clock& clock);

}  // namespace kasumi
