#include "tests/pipeline/appliance/faulty_display.hpp"

#include <new>

namespace kasumi {

namespace {

// A context with other limits.
class FaultyContext final : public GlContext {
 public:
  FaultyContext(GlContext& context, const DisplayFaults& faults)
      : context_(context), faults_(faults), info_(context.info()) {}
  const GlInfo& info() const override {
    info_.max_texture_size = faults_.largest_texture > 0 ? faults_.largest_texture : context_.info().max_texture_size;
    return info_;
  }
  Result<> make_current() override { return context_.make_current(); }
  Result<> check_alive() override { return context_.check_alive(); }

 private:
  GlContext& context_;
  const DisplayFaults& faults_;
  mutable GlInfo info_;
};

class FaultyDisplay final : public Display {
 public:
  FaultyDisplay(std::unique_ptr<HeadlessDisplay> display, DisplayFaults& faults)
      : display_(std::move(display)), context_(display_->context(), faults), faults_(faults) {}
  std::string description() const override { return display_->description(); }
  GlContext& context() override { return context_; }

  Result<DrawTarget> begin(Instant deadline) override {
    if (faults_.unplugged) return fail(FaultKind::disconnected, "HDMI-A-1: disconnected");
    if (std::exchange(faults_.context_lost, false)) return fail(FaultKind::device, "the GL context is lost");
    if (faults_.busy) return fail(FaultKind::device, "page flip: EACCES");
    if (faults_.throws) throw std::bad_alloc();
    if (faults_.stuck) return fail(FaultKind::timeout, "the flip does not complete");
    return display_->begin(deadline);
  }
  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced) override {
    seen_.reset();
    faults_.off = false;
    return display_->show(std::move(until_replaced));
  }
  std::vector<Flip> take_flips() override { return faults_.stuck ? std::vector<Flip>{} : display_->take_flips(); }
  Result<> turn_off() override {
    if (faults_.stays_on) return Display::turn_off();
    faults_.off = true;
    return {};
  }
  Result<Image<Rgb8>> read() {
    if (!seen_) {
      auto read = display_->read();
      if (!read) return read;
      seen_ = std::move(*read);
    }
    return *seen_;
  }

 private:
  std::unique_ptr<HeadlessDisplay> display_;
  FaultyContext context_;
  DisplayFaults& faults_;
  std::optional<Image<Rgb8>> seen_;
};

class FaultyWatch final : public DisplayWatch {
 public:
  explicit FaultyWatch(DisplayFaults& faults) : faults_(faults) {}
  bool take_change() override { return std::exchange(faults_.told, false); }

 private:
  DisplayFaults& faults_;
};

}  // namespace

std::unique_ptr<DisplayWatch> watch_faulty_display(DisplayFaults& faults) {
  return std::make_unique<FaultyWatch>(faults);
}

Result<std::unique_ptr<Display>> open_faulty_display(const HeadlessDisplayOptions& options, Clock& clock,
                                                     DisplayFaults& faults) {
  ++faults.tried;
  if (faults.unplugged) return fail(FaultKind::disconnected, "no connected connector");
  if (faults.busy) return fail(FaultKind::device, "EBUSY: another program is DRM master");
  auto given = options;
  if (faults.other_size) std::tie(given.width, given.height) = *faults.other_size;
  auto display = open_headless_display(given, clock);
  if (!display) return fail(display.error());
  ++faults.opened;
  if (faults.opening_mends) faults.stuck = false;
  return std::make_unique<FaultyDisplay>(std::move(*display), faults);
}

Result<Image<Rgb8>> read_picture(Display& display) {
  return dynamic_cast<FaultyDisplay&>(display).read();
}

}  // namespace kasumi
