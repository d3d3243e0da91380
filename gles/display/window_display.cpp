// A desktop window as a display.
#include <utility>

#include "gles/display/display.hpp"
#include "gles/display/flip_record.hpp"
#include "gles/display/window.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {
namespace {

class WindowDisplay final : public Display {
 public:
  WindowDisplay(std::unique_ptr<Window> window, Clock& clock) : window_(std::move(window)), flips_(clock) {}

  std::string description() const override {
    const DrawTarget target = window_->target();
    return fmt::format("window {}x{}, {}", target.width, target.height, window_->info().renderer);
  }
  GlContext& context() override { return *window_; }

  Result<DrawTarget> begin(Instant) override {
    if (!window_->handle_events()) return fail(FaultKind::end_of_stream, "the window was closed");
    if (auto current = window_->make_current(); !current) return fail(current.error());
    return window_->target();
  }

  // BLOCKS until the desktop's compositor accepts the picture, for an unbounded time: the window is for previews, and
  // the appliance uses KMS.
  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced) override {
    if (auto current = window_->make_current(); !current) return fail(current.error());
    window_->show();
    glFinish();  // the previous picture is no longer read
    if (auto finished = check_gl("showing a picture in the window"); !finished) return fail(finished.error());
    return flips_.shown(std::move(until_replaced));
  }

  std::vector<Flip> take_flips() override { return flips_.take(); }
  DisplayCounts counts() const override { return flips_.counts(); }

 private:
  std::unique_ptr<Window> window_;
  ImmediateFlips flips_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_window_display(const WindowDisplayOptions& options, Clock& clock) {
  auto window =
      open_window({.title = options.title, .width = options.width, .height = options.height, .wait_for_refresh = true});
  if (!window) return fail(window.error());
  return std::make_unique<WindowDisplay>(std::move(*window), clock);
}

}  // namespace kasumi
