#include "gles/display/headless_display.hpp"

#include <array>
#include <utility>

#include "gles/display/flip_record.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/offscreen.hpp"

namespace kasumi {
namespace {

// Double-buffered: one framebuffer holds the picture shown last while the next is drawn into the other.
class OffscreenDisplay final : public HeadlessDisplay {
 public:
  OffscreenDisplay(std::unique_ptr<GlContext> context, std::array<Offscreen, 2> pictures, Clock& clock)
      : context_(std::move(context)), pictures_(std::move(pictures)), flips_(clock) {}
  OffscreenDisplay(const OffscreenDisplay&) = delete;
  OffscreenDisplay& operator=(const OffscreenDisplay&) = delete;
  ~OffscreenDisplay() override {
    // The framebuffers are deleted under their own context, whichever is current now.
    (void)context_->make_current();
  }

  std::string description() const override {
    const DrawTarget target = pictures_[0].target();
    return fmt::format("headless {}x{}, {}", target.width, target.height, context_->info().renderer);
  }
  GlContext& context() override { return *context_; }

  Result<DrawTarget> begin(Instant) override {
    if (auto current = context_->make_current(); !current) return fail(current.error());
    if (auto alive = context_->check_alive(); !alive) return fail(alive.error());
    return drawn().target();
  }

  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced) override {
    if (auto current = context_->make_current(); !current) return fail(current.error());
    glFinish();  // a picture counts as shown once drawn, and the one before is no longer read
    if (auto finished = check_gl("drawing a picture"); !finished) return fail(finished.error());
    return flips_.shown(std::move(until_replaced));
  }

  std::vector<Flip> take_flips() override { return flips_.take(); }
  DisplayCounts counts() const override { return flips_.counts(); }

  Result<Image<Rgb8>> read() override {
    if (flips_.number() == 0) return fail(FaultKind::bad_input, "the headless display has not shown a picture yet");
    if (auto current = context_->make_current(); !current) return fail(current.error());
    return pictures_[(flips_.number() - 1) % 2].read();
  }

 private:
  Offscreen& drawn() { return pictures_[flips_.number() % 2]; }

  std::unique_ptr<GlContext> context_;
  std::array<Offscreen, 2> pictures_;
  ImmediateFlips flips_;
};

}  // namespace

Result<std::unique_ptr<HeadlessDisplay>> open_headless_display(const HeadlessDisplayOptions& options, Clock& clock) {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  auto first = Offscreen::create((*context)->info(), options.width, options.height);
  if (!first) return fail(first.error());
  auto second = Offscreen::create((*context)->info(), options.width, options.height);
  if (!second) return fail(second.error());
  return std::make_unique<OffscreenDisplay>(std::move(*context),
                                            std::array<Offscreen, 2>{std::move(*first), std::move(*second)}, clock);
}

}  // namespace kasumi
