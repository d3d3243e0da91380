#include "tests/pipeline/kiosk/appliance/faulty_display.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <new>

#include <glm/vec4.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/offscreen.hpp"

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

class OffscreenPlane final : public PlaneBuffer {
 public:
  explicit OffscreenPlane(Offscreen picture) : picture_(std::move(picture)) {}
  DrawTarget target() const override { return picture_.target(); }
  std::uint32_t framebuffer() const override { return 1; }

 private:
  Offscreen picture_;
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
    ++faults_.composed;
    return display_->show(std::move(until_replaced));
  }
  // Blends as display controllers do: premultiplied, encoded.
  Result<std::uint64_t> show_planes(const PlaneStack& picture, std::shared_ptr<const void> until_replaced) override {
    if (!faults_.planes) return Display::show_planes(picture, std::move(until_replaced));
    if (faults_.refused_planes > 0) {
      --faults_.refused_planes;
      return fail(FaultKind::unsupported, "showing planes: No space left on device");
    }
    const ExternalPicture& camera = picture.camera;
    Image<Rgb8> blended(camera.width, camera.height);
    for (int y = 0; y < camera.height; ++y)
      if (pread(camera.fd, blended.row(y), 3u * static_cast<std::size_t>(camera.width),
                camera.planes[0].offset + y * static_cast<off_t>(camera.planes[0].stride)) < 0)
        return fail(FaultKind::device, "the camera's buffer cannot be read");
    if (picture.building) {
      const auto target = picture.building->target();
      Image<glm::u8vec4> above(target.width, target.height);
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
      glReadPixels(0, 0, target.width, target.height, GL_RGBA, GL_UNSIGNED_BYTE, above.elements().data());
      for (int y = picture.top; y < picture.bottom; ++y)
        for (int x = picture.left; x < picture.right; ++x) {
          const auto over = above.at(x - picture.left + picture.source_left, y - picture.top + picture.source_top);
          auto& pixel = blended.at(x, y);
          for (int c = 0; c < 3; ++c)
            pixel[c] = static_cast<std::uint8_t>(
                std::min(255, over[c] + static_cast<int>(std::lround((255 - over.a) * pixel[c] / 255.0))));
        }
    }
    auto number = display_->show(
        std::make_shared<std::pair<std::shared_ptr<const void>, PlaneStack>>(std::move(until_replaced), picture));
    seen_ = std::move(blended);
    faults_.off = false;
    ++faults_.on_planes;
    return number;
  }
  Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int width, int height) override {
    if (!faults_.planes) return Display::make_plane_buffer(width, height);
    auto made = Offscreen::create(context_.info(), width, height);
    if (!made) return fail(made.error());
    return std::make_shared<OffscreenPlane>(std::move(*made));
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
