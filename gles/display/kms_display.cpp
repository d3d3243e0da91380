#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "gles/display/kms_camera_buffers.hpp"
#include "gles/display/kms_choice.hpp"
#include "gles/display/kms_flips.hpp"
#include "gles/display/kms_plane_choice.hpp"
#include "gles/display/kms_system.hpp"
#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

constexpr Duration kCheckInterval = std::chrono::seconds(1);  // of the kernel's cached state
constexpr Duration kMinProbeInterval =
    std::chrono::milliseconds(250);  // minimum interval, since probing a display is slow

// The card with its connector and mode: everything of a display except GL.
struct Opened {
  std::unique_ptr<KmsDevice> device;
  KmsConnector connector;
};

class KmsDisplay final : public Display {
 public:
  KmsDisplay(std::shared_ptr<KmsSystem> system, Opened opened, const KmsPipe& pipe, std::unique_ptr<Scanout> scanout,
             std::unique_ptr<DisplayWatch> watch, const KmsDisplayOptions& options, Clock& clock)
      : system_(std::move(system)),
        device_(std::move(opened.device)),
        connector_(std::move(opened.connector)),
        pipe_(pipe),
        scanout_(std::move(scanout)),
        watch_(std::move(watch)),
        clock_(clock),
        mode_is_instead_(options.width > 0 && (pipe.mode.width != options.width || pipe.mode.height != options.height)),
        cameras_(*device_),
        flips_(*device_, pipe, options.atomic && device_->has_atomic(), options.flip_deadline, clock),
        next_check_(clock.now() + kCheckInterval) {
    device_->remember(pipe);
  }
  KmsDisplay(const KmsDisplay&) = delete;
  KmsDisplay& operator=(const KmsDisplay&) = delete;
  ~KmsDisplay() override {
    // Restores the console before freeing the pictures, because removing the shown framebuffer turns the screen off.
    if (flips_.is_healthy() && device_->is_master() && device_->connection(connector_) != KmsConnection::disconnected)
      device_->restore();
    (void)scanout_->context().make_current();
  }

  std::string description() const override {
    return fmt::format("{} ({}) {} {}{}, {}, {}", device_->path(), device_->driver(), connector_.name,
                       pipe_.mode.text(), mode_is_instead_ ? " (the mode asked for is not offered)" : "",
                       flips_.atomic() ? "atomic" : "legacy", scanout_->context().info().renderer);
  }
  GlContext& context() override { return scanout_->context(); }

  Result<DrawTarget> begin(Instant deadline) override {
    if (auto there = check_display(); !there) return fail(there.error());
    if (auto settled = flips_.settle(deadline); !settled) return fail(named(settled.error()));
    if (auto current = context().make_current(); !current) return fail(current.error());
    if (auto alive = context().check_alive(); !alive) return fail(alive.error());
    if (!scanout_->has_free_buffer())
      return fail(FaultKind::device, "{}: no free buffer to draw into", device_->path());
    return scanout_->target();
  }

  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced) override {
    if (!flips_.is_settled()) return fail(FaultKind::timeout, "the picture before is still on its way to the display");
    if (auto current = context().make_current(); !current) return fail(current.error());
    // Software GL draws into memory without fences.
    if (context().info().software) glFinish();
    auto picture = scanout_->finish();
    if (!picture) return fail(picture.error());
    const std::uint64_t number = ++number_;
    if (auto sent = flips_.submit({number, std::move(*picture), {}, std::move(until_replaced)}); !sent)
      return fail(named(sent.error()));
    cameras_.drop();
    return number;
  }

  Result<std::uint64_t> show_planes(const PlaneStack& picture, std::shared_ptr<const void> until_replaced) override {
    if (!flips_.is_settled()) return fail(FaultKind::timeout, "the picture before is still on its way to the display");
    const ExternalPicture& camera = picture.camera;
    if (camera.width != pipe_.mode.width || camera.height != pipe_.mode.height)
      return fail(FaultKind::unsupported,
                  "the camera's pictures of {} x {} pixels are not of the screen's size, {} x {}", camera.width,
                  camera.height, pipe_.mode.width, pipe_.mode.height);
    if (camera.layout == PixelLayout::grey8) return fail(FaultKind::unsupported, "planes do not show grey pictures");
    const auto framebuffer = cameras_.import(camera);
    if (!framebuffer) return fail(framebuffer.error());
    const PlaneKind kind{camera.layout, camera.encoding, picture.building != nullptr};
    if (!pair_ || kind_ != kind) {
      auto chosen = choose_pair(picture, **framebuffer);
      if (!chosen) return fail(named(chosen.error()));
      pair_ = *chosen;
      kind_ = kind;
    }
    if (context().info().software)
      glFinish();  // as in show()
    else
      glFlush();
    const std::uint64_t number = ++number_;
    const auto kept = std::make_shared<std::array<std::shared_ptr<const void>, 3>>(
        std::array<std::shared_ptr<const void>, 3>{std::move(until_replaced), picture.building, *framebuffer});
    if (auto sent = flips_.submit_planes({number, nullptr, states(*pair_, picture, **framebuffer), kept}); !sent)
      return fail(named(sent.error()));
    return number;
  }
  Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int width, int height) override {
    return scanout_->make_plane_buffer(width, height);
  }

  std::vector<Flip> take_flips() override {
    (void)flips_.advance();  // faults are reported by the next begin()
    return flips_.take_flips();
  }
  DisplayCounts counts() const override { return flips_.counts(); }
  Result<> turn_off() override {
    if (auto advanced = flips_.advance(); !advanced) return fail(named(advanced.error()));
    if (!flips_.is_settled()) return fail(FaultKind::timeout, "the picture before is still on its way to the display");
    if (auto off = flips_.turn_off(); !off) return fail(named(off.error()));
    return {};
  }

 private:
  struct PlaneKind {
    PixelLayout layout{};
    YuvEncoding encoding{};
    bool building = false;
    friend bool operator==(const PlaneKind&, const PlaneKind&) = default;
  };

  static std::optional<YuvEncoding> encoding_of(const ExternalPicture& camera) {
    return is_yuv(camera.layout) ? std::optional(camera.encoding) : std::nullopt;
  }
  static std::vector<KmsPlaneState> states(const KmsPlanePair& pair, const PlaneStack& picture,
                                           const KmsFramebuffer& camera) {
    KmsPlaneState below{pair.camera, camera.id(), {0, 0, picture.camera.width, picture.camera.height}};
    below.zpos = pair.camera_zpos;
    below.encoding = encoding_of(picture.camera);
    KmsPlaneState above{.plane = pair.building};
    if (picture.building) {
      above.framebuffer = picture.building->framebuffer();
      above.source = {picture.source_left, picture.source_top, picture.right - picture.left,
                      picture.bottom - picture.top};
      above.x = picture.left;
      above.y = picture.top;
      above.zpos = pair.building_zpos;
      above.blends = true;
    }
    return {below, above};
  }
  // The first pair of planes that the driver takes.
  Result<KmsPlanePair> choose_pair(const PlaneStack& picture, const KmsFramebuffer& camera) {
    const auto planes = device_->planes(pipe_);
    if (!planes) return fail(FaultKind::unsupported, "{}", planes.error().what);
    const auto pairs =
        choose_planes(*planes, pipe_.plane, drm_format_of(picture.camera.layout), encoding_of(picture.camera));
    if (!pairs) return fail(pairs.error());
    Result<> asked;
    for (const KmsPlanePair& pair : *pairs) {
      asked = flips_.ask_for_planes(states(pair, picture, camera));
      if (asked) return pair;
    }
    return fail(asked.error());
  }

  // Adds which process is DRM master now.
  Fault named(Fault fault) const {
    if (fault.kind != FaultKind::device || device_->is_master()) return fault;
    const std::string users = system_->users_of(device_->path());
    if (!users.empty()) fault.message += "; " + users;
    return fault;
  }

  Result<> check_display() {
    const Instant now = clock_.now();
    if (watch_ && watch_->take_change()) changed_ = true;
    if (now >= next_check_) {
      next_check_ = now + kCheckInterval;
      if (device_->connection(connector_) == KmsConnection::disconnected) changed_ = true;
      if (!device_->is_master())
        return fail(named({FaultKind::device, fmt::format("{}: another process became DRM master", device_->path())}));
    }
    if (!changed_ || now < next_probe_) return {};
    changed_ = false;
    next_probe_ = now + kMinProbeInterval;
    return probe();
  }

  Result<> probe() {
    const auto found = device_->connector(connector_.id);
    if (!found) return fail(FaultKind::disconnected, "{} no longer exists: {}", connector_.name, found.error().what);
    if (found->connection == KmsConnection::disconnected)
      return fail(FaultKind::disconnected, "the display was unplugged from {}", connector_.name);
    if (found->modes.empty())
      return fail(FaultKind::disconnected, "the display at {} now lists no modes (is it off?)", connector_.name);
    if (found->identity != connector_.identity)
      return fail(FaultKind::disconnected, "another display was plugged into {}", connector_.name);
    if (std::ranges::none_of(found->modes, [&](const KmsMode& mode) { return mode.same_timing(pipe_.mode); }))
      return fail(FaultKind::disconnected, "the display at {} no longer offers {}", connector_.name, pipe_.mode.text());
    if (found->link_bad) flips_.set_mode_again();
    return {};
  }

  std::shared_ptr<KmsSystem> system_;
  std::unique_ptr<KmsDevice> device_;
  KmsConnector connector_;
  KmsPipe pipe_;
  std::unique_ptr<Scanout> scanout_;
  std::unique_ptr<DisplayWatch> watch_;
  Clock& clock_;
  bool mode_is_instead_;
  KmsCameraBuffers cameras_;
  std::optional<KmsPlanePair> pair_;  // that the driver takes for pictures of this kind
  PlaneKind kind_;
  KmsFlips flips_;  // declared after the scanout, so that its pictures are freed first
  std::uint64_t number_ = 0;
  Instant next_check_;
  Instant next_probe_{};
  bool changed_ = false;
};

std::string hint(std::errc code) {
  if (code == std::errc::permission_denied) return " (is this user in the group \"video\"?)";
  return "";
}

Result<Opened> open_card(KmsSystem& system, const std::string& path, const KmsDisplayOptions& options) {
  auto device = system.open_card(path);
  if (!device) {
    const std::errc code = device.error().code;
    const bool absent = code == std::errc::no_such_file_or_directory || code == std::errc::no_such_device ||
                        code == std::errc::no_such_device_or_address;
    const bool no_display = code == std::errc::operation_not_supported;
    return fail(absent       ? FaultKind::disconnected
                : no_display ? FaultKind::unsupported
                             : FaultKind::device,
                "{}{}", device.error().what, hint(code));
  }
  const auto connectors = (*device)->connectors();
  if (!connectors) return fail(FaultKind::device, "{}", connectors.error().what);
  auto connector = choose_connector(*connectors, options.connector);
  if (!connector) return fail(connector.error().kind, "{}: {}", path, connector.error().message);
  return Opened{std::move(*device), std::move(*connector)};
}

// The first card that meets the options. Otherwise the fault is that of the most suitable card: one that only lacks its
// display, before one that refuses, has no such connector, or drives no displays at all.
Result<Opened> open_first_card(KmsSystem& system, const KmsDisplayOptions& options) {
  std::vector<KmsCardPlace> places;
  if (options.device.empty())
    places = system.cards();
  else
    places.push_back({options.device, ""});
  if (places.empty()) return fail(FaultKind::disconnected, "there is no graphics card with a display output");

  constexpr std::array kOrder{FaultKind::disconnected, FaultKind::device, FaultKind::bad_input, FaultKind::unsupported};
  const auto rank = [&](FaultKind kind) { return std::ranges::find(kOrder, kind) - kOrder.begin(); };
  Fault fault{FaultKind::unsupported, ""};
  for (const KmsCardPlace& place : places) {
    auto opened = open_card(system, place.path, options);
    if (opened) return opened;
    if (rank(opened.error().kind) < rank(fault.kind)) fault.kind = opened.error().kind;
    fault.message += (fault.message.empty() ? "" : "\n") + opened.error().message;
  }
  return fail(std::move(fault));
}

Result<> become_master(KmsSystem& system, KmsDevice& device) {
  if (const auto master = device.become_master(); !master) {
    const std::string users = system.users_of(device.path());
    return fail(FaultKind::device, "{}: another process is DRM master{}{}", master.error().what,
                users.empty() ? "" : "; ", users);
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Display>> open_kms_display(const KmsDisplayOptions& options, Clock& clock,
                                                  std::shared_ptr<KmsSystem> system) {
  auto opened = open_first_card(*system, options);
  if (!opened) return fail(opened.error());
  KmsDevice& device = *opened->device;
  const auto mode = choose_mode(opened->connector, options);
  if (!mode) return fail(mode.error().kind, "{}: {}", device.path(), mode.error().message);
  if (auto master = become_master(*system, device); !master) return fail(master.error());
  const auto pipe = device.find_pipe(opened->connector, *mode);
  if (!pipe) return fail(FaultKind::device, "{}", pipe.error().what);
  auto scanout = system->open_scanout(device, mode->width, mode->height);
  if (!scanout) return fail(scanout.error());
  auto watch = system->watch();  // without udev the periodic check finds changes up to a second later
  return std::make_unique<KmsDisplay>(std::move(system), std::move(*opened), *pipe, std::move(*scanout),
                                      watch ? std::move(*watch) : nullptr, options, clock);
}

Result<std::unique_ptr<Display>> open_kms_display(const KmsDisplayOptions& options, Clock& clock) {
  return open_kms_display(options, clock, open_kms_system());
}

}  // namespace kasumi
