// A scripted graphics card with its displays, for faults that no real card shows on demand. It runs on a manual clock,
// which waiting for the card advances.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/unique_fd.hpp"
#include "gles/display/kms_system.hpp"
#include "gles/gl/offscreen.hpp"

namespace kasumi {

inline KmsMode fake_mode(int width, int height, double refresh_hz, bool preferred = false, bool interlaced = false) {
  KmsMode mode;
  mode.width = width;
  mode.height = height;
  mode.refresh_hz = refresh_hz;
  mode.preferred = preferred;
  mode.interlaced = interlaced;
  const std::string timing = mode.text();
  std::copy_n(timing.begin(), std::min(timing.size(), mode.timing.size()), mode.timing.begin());
  return mode;
}

inline KmsConnector fake_connector(std::uint32_t id, std::string name, std::vector<KmsMode> modes,
                                   KmsConnection connection = KmsConnection::connected) {
  KmsConnector connector;
  connector.id = id;
  connector.name = std::move(name);
  connector.connection = connection;
  connector.modes = std::move(modes);
  connector.crtcs = {40};
  connector.identity = 7;
  return connector;
}

inline KmsPlane fake_plane(std::uint32_t id, KmsPlane::Kind kind) {
  KmsPlane plane;
  plane.id = id;
  plane.kind = kind;
  plane.formats = {drm_format("XR24"), drm_format("AR24")};
  return plane;
}

// The state of a card independent of any program that opens it: what is plugged in, who is master, which faults it has.
struct FakeCard {
  explicit FakeCard(ManualClock& manual) : clock(manual) {}

  ManualClock& clock;
  bool present = true;
  bool has_atomic = true;
  std::vector<KmsConnector> connectors{
      fake_connector(30, "HDMI-A-1", {fake_mode(64, 48, 60, true), fake_mode(64, 48, 50), fake_mode(32, 24, 60)})};
  Duration refresh = std::chrono::nanoseconds(16'666'667);
  std::vector<KmsPlane> planes{fake_plane(50, KmsPlane::Kind::primary), fake_plane(51, KmsPlane::Kind::overlay)};
  int most_overlay_pixels = 1 << 20;  // beyond that the card's memory is too slow (ENOSPC)

  // Faults: how many of the next calls fail this way; applied in this order.
  int lost_events = 0;
  int busy = 0;
  std::deque<std::errc> refusals;              // of any commit
  std::deque<std::errc> atomic_mode_refusals;  // of commit_mode only
  bool stuck = false;                          // the driver accepts a flip, never completes it and is busy from then on
  bool master_elsewhere = false;
  bool gl_lost = false;
  bool no_import = false;   // of other drivers' buffers
  Duration event_offset{};  // what the driver's timestamps are wrong by

  // What happened.
  std::vector<std::string> calls;  // "commit_mode wait", "commit_flip", "set_crtc", "page_flip", "restore", ...
  std::vector<std::uint64_t> on_the_glass;  // numbers of pictures
  bool asleep = false;                      // turned off, and no mode set since
  int open_devices = 0;
  int probes = 0;
  std::map<std::uint32_t, KmsBuffer> framebuffers;
  std::map<std::uint32_t, KmsPlaneState> shown;  // on planes, by their number; empty: the picture that fills the screen
  std::set<std::uint32_t> locked;                // framebuffers whose buffers are in use
  bool changed = false;                          // since the watch was last read

  void plug(const KmsConnector& connector) {
    connectors = {connector};
    changed = true;
  }
  void unplug(bool notify = true) {
    connectors[0].connection = KmsConnection::disconnected;
    connectors[0].modes.clear();
    changed = notify;
  }
  int count(const std::string& call) const { return static_cast<int>(std::ranges::count(calls, call)); }
};

class FakeDevice final : public KmsDevice {
 public:
  explicit FakeDevice(FakeCard& card) : card_(card), open_file_(dup(0)) { ++card_.open_devices; }
  FakeDevice(const FakeDevice&) = delete;
  FakeDevice& operator=(const FakeDevice&) = delete;
  ~FakeDevice() override { --card_.open_devices; }

  const std::string& path() const override { return path_; }
  const std::string& driver() const override { return driver_; }
  int fd() const override { return open_file_.value(); }
  bool has_atomic() const override { return card_.has_atomic; }
  KmsResult<> become_master() override {
    if (card_.master_elsewhere) return error(std::errc::device_or_resource_busy, "becoming DRM master");
    return {};
  }
  bool is_master() const override { return !card_.master_elsewhere; }
  void drop_master() override { card_.calls.emplace_back("drop_master"); }

  KmsResult<std::vector<KmsConnector>> connectors() override {
    ++card_.probes;
    if (!card_.present) return error(std::errc::no_such_device, "listing");
    return card_.connectors;
  }
  KmsResult<KmsConnector> connector(std::uint32_t id) override {
    ++card_.probes;
    for (const KmsConnector& one : card_.connectors)
      if (one.id == id && card_.present) return one;
    return error(std::errc::no_such_device, "asking for a connector");
  }
  KmsConnection connection(const KmsConnector& connector) const override {
    for (const KmsConnector& one : card_.connectors)
      if (one.id == connector.id && card_.present) return one.connection;
    return KmsConnection::disconnected;
  }
  KmsResult<KmsPipe> find_pipe(const KmsConnector& connector, const KmsMode& mode) override {
    return KmsPipe{connector.id, 40, 50, mode};
  }
  KmsResult<std::vector<KmsPlane>> planes(const KmsPipe&) override { return card_.planes; }
  KmsResult<std::uint32_t> add_framebuffer(const KmsBuffer& buffer) override {
    if (buffer.dma_buf >= 0 && card_.no_import) return error(std::errc::invalid_argument, "importing");
    const std::uint32_t id = next_framebuffer_++;
    card_.framebuffers.emplace(id, buffer);
    return id;
  }
  void remove_framebuffer(std::uint32_t framebuffer) override {
    card_.framebuffers.erase(framebuffer);
    card_.calls.emplace_back("remove_framebuffer");
  }

  KmsResult<> commit_mode(const KmsPipe&, const KmsFrame& frame, KmsWait wait) override {
    card_.calls.emplace_back(wait == KmsWait::no ? "commit_mode" : "commit_mode wait");
    if (!card_.atomic_mode_refusals.empty()) {
      const std::errc code = card_.atomic_mode_refusals.front();
      card_.atomic_mode_refusals.pop_front();
      return error(code, "setting the mode");
    }
    auto queued = queue(frame, "setting the mode");
    if (!queued) return queued;
    card_.asleep = false;
    card_.shown.clear();
    return queued;
  }
  KmsResult<> commit_flip(const KmsPipe&, const KmsFrame& frame) override {
    card_.calls.emplace_back("commit_flip");
    if (card_.asleep)
      return error(std::errc::invalid_argument, "page flip");  // as the kernel does: the CRTC is not active
    return queue(frame, "page flip");
  }
  KmsResult<> commit_planes(const KmsPipe&, std::span<const KmsPlaneState> planes, std::uint64_t number,
                            KmsTrial trial) override {
    const std::string what = trial == KmsTrial::only_ask ? "ask_for_planes" : "commit_planes";
    card_.calls.emplace_back(what);
    auto shown = card_.shown;
    for (const KmsPlaneState& state : planes) {
      if (state.framebuffer == 0)
        shown.erase(state.plane);
      else
        shown[state.plane] = state;
    }
    if (card_.asleep) return error(std::errc::invalid_argument, what);
    if (auto whole = check_planes(shown, what); !whole) return whole;
    if (trial == KmsTrial::only_ask) return {};
    auto queued = queue({planes[0].framebuffer, number}, what);
    if (queued) card_.shown = shown;
    return queued;
  }
  KmsResult<> set_crtc(const KmsPipe&, const KmsFrame& frame) override {
    card_.calls.emplace_back("set_crtc");
    if (auto refused = next_refusal("setting the mode (legacy)"); !refused) return refused;
    queued_.reset();
    card_.asleep = false;
    show(frame);
    return {};
  }
  KmsResult<> page_flip(const KmsPipe&, const KmsFrame& frame) override {
    card_.calls.emplace_back("page_flip");
    if (card_.asleep) return error(std::errc::invalid_argument, "page flip (legacy)");
    return queue(frame, "page flip (legacy)");
  }

  KmsResult<> turn_off(const KmsPipe&, bool atomic) override {
    card_.calls.emplace_back(atomic ? "turn_off" : "turn_off legacy");
    if (auto refused = next_refusal("turning off"); !refused) return refused;
    card_.asleep = true;
    return {};
  }

  KmsResult<std::vector<KmsEvent>> wait_events(Duration at_most) override {
    if (!card_.present) return error(std::errc::no_such_device, "waiting");
    std::vector<KmsEvent> events;
    const Instant until = card_.clock.now() + at_most;
    if (queued_ && !card_.stuck && flips_at_ <= until) {
      if (flips_at_ > card_.clock.now()) card_.clock.advance(flips_at_ - card_.clock.now());
      show(*queued_);
      const KmsEvent event{queued_->number, card_.clock.now() + card_.event_offset};
      queued_.reset();
      if (card_.lost_events > 0)
        --card_.lost_events;
      else
        events.push_back(event);
    }
    if (events.empty() && until > card_.clock.now()) card_.clock.advance(until - card_.clock.now());
    return events;
  }
  void remember(const KmsPipe&) override { card_.calls.emplace_back("remember"); }
  void restore() override { card_.calls.emplace_back("restore"); }

 private:
  static tl::unexpected<KmsError> error(std::errc code, const std::string& what) {
    return tl::unexpected<KmsError>(KmsError{code, what + ": " + std::make_error_code(code).message()});
  }
  // As the kernel and its drivers do.
  KmsResult<> check_planes(const std::map<std::uint32_t, KmsPlaneState>& shown, const std::string& what) const {
    int overlay_pixels = 0;
    for (const auto& [id, state] : shown) {
      const auto plane = std::ranges::find(card_.planes, id, &KmsPlane::id);
      const auto buffer = card_.framebuffers.find(state.framebuffer);
      if (plane == card_.planes.end() || buffer == card_.framebuffers.end())
        return error(std::errc::no_such_file_or_directory, what);
      if (std::ranges::find(plane->formats, buffer->second.format) == plane->formats.end())
        return error(std::errc::invalid_argument, what);
      if (state.zpos && (!plane->zpos || plane->zpos->fixed || *state.zpos > plane->zpos->most))
        return error(std::errc::invalid_argument, what);
      if (plane->kind == KmsPlane::Kind::overlay) overlay_pixels += state.source.width * state.source.height;
    }
    if (overlay_pixels > card_.most_overlay_pixels) return error(std::errc::no_space_on_device, what);
    return {};
  }
  KmsResult<> next_refusal(const std::string& what) {
    if (!card_.present) return error(std::errc::no_such_device, what);
    if (card_.master_elsewhere) return error(std::errc::permission_denied, what);
    if (card_.busy > 0) {
      --card_.busy;
      return error(std::errc::device_or_resource_busy, what);
    }
    if (!card_.refusals.empty()) {
      const std::errc code = card_.refusals.front();
      card_.refusals.pop_front();
      return error(code, what);
    }
    return {};
  }
  KmsResult<> queue(const KmsFrame& frame, const std::string& what) {
    if (auto refused = next_refusal(what); !refused) return refused;
    if (queued_) return error(std::errc::device_or_resource_busy, what);  // as the kernel does: one at a time
    if (!card_.framebuffers.contains(frame.framebuffer)) return error(std::errc::no_such_file_or_directory, what);
    queued_ = frame;
    const auto periods = card_.clock.now().time_since_epoch() / card_.refresh;
    flips_at_ = Instant{} + (periods + 1) * card_.refresh;
    return {};
  }
  void show(const KmsFrame& frame) { card_.on_the_glass.push_back(frame.number); }

  FakeCard& card_;
  UniqueFd open_file_;
  std::string path_ = "/dev/dri/card9";
  std::string driver_ = "fake";
  std::uint32_t next_framebuffer_ = 100;
  std::optional<KmsFrame> queued_;
  Instant flips_at_{};
};

// A context of the machine's GL whose loss can be simulated.
class LosableContext final : public GlContext {
 public:
  LosableContext(std::unique_ptr<GlContext> real, FakeCard& card) : real_(std::move(real)), card_(card) {}
  const GlInfo& info() const override { return real_->info(); }
  Result<> make_current() override { return real_->make_current(); }
  Result<> check_alive() override {
    if (card_.gl_lost) return fail(FaultKind::device, "GL context lost: simulated");
    return real_->check_alive();
  }

 private:
  std::unique_ptr<GlContext> real_;
  FakeCard& card_;
};

class FakeScanout final : public Scanout {
 public:
  FakeScanout(std::unique_ptr<GlContext> context, Offscreen picture, KmsDevice& device, FakeCard& card)
      : context_(std::make_unique<LosableContext>(std::move(context), card)),
        picture_(std::move(picture)),
        device_(device),
        card_(card) {
    for (int i = 0; i < 3; ++i) framebuffers_.push_back(std::move(*KmsFramebuffer::add(device, {})));
  }
  GlContext& context() override { return *context_; }
  bool has_free_buffer() const override { return card_.locked.size() < framebuffers_.size(); }
  DrawTarget target() const override { return picture_.target(); }
  Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int width, int height) override {
    auto picture = Offscreen::create(context_->info(), width, height);
    if (!picture) return fail(picture.error());
    KmsBuffer buffer;
    buffer.format = drm_format("AR24");
    return std::make_shared<Plane>(std::move(*picture), std::move(*KmsFramebuffer::add(device_, buffer)));
  }
  Result<std::unique_ptr<ScanoutPicture>> finish() override {
    for (const KmsFramebuffer& framebuffer : framebuffers_)
      if (!card_.locked.contains(framebuffer.id())) return std::make_unique<Picture>(card_, framebuffer.id());
    return fail(FaultKind::device, "no free buffer");
  }

 private:
  class Picture final : public ScanoutPicture {
   public:
    Picture(FakeCard& card, std::uint32_t framebuffer) : card_(card), framebuffer_(framebuffer) {
      card_.locked.insert(framebuffer_);
    }
    Picture(const Picture&) = delete;
    Picture& operator=(const Picture&) = delete;
    ~Picture() override { card_.locked.erase(framebuffer_); }
    std::uint32_t framebuffer() const override { return framebuffer_; }

   private:
    FakeCard& card_;
    std::uint32_t framebuffer_;
  };

  class Plane final : public PlaneBuffer {
   public:
    Plane(Offscreen picture, KmsFramebuffer shown) : picture_(std::move(picture)), shown_(std::move(shown)) {}
    DrawTarget target() const override { return picture_.target(); }
    std::uint32_t framebuffer() const override { return shown_.id(); }

   private:
    Offscreen picture_;
    KmsFramebuffer shown_;
  };

  std::unique_ptr<GlContext> context_;
  Offscreen picture_;
  KmsDevice& device_;
  FakeCard& card_;
  std::vector<KmsFramebuffer> framebuffers_;
};

class FakeWatch final : public DisplayWatch {
 public:
  explicit FakeWatch(FakeCard& card) : card_(card) {}
  bool take_change() override { return std::exchange(card_.changed, false); }

 private:
  FakeCard& card_;
};

class FakeSystem final : public KmsSystem {
 public:
  explicit FakeSystem(FakeCard& card) : card_(card) {}
  bool has_udev = true;
  std::string users;

  std::vector<KmsCardPlace> cards() override {
    if (!card_.present) return {};
    return {{"/dev/dri/card9", "/dev/dri/by-path/fake-card"}};
  }
  KmsResult<std::unique_ptr<KmsDevice>> open_card(const std::string& path) override {
    if (!card_.present || path != "/dev/dri/card9")
      return tl::unexpected<KmsError>({std::errc::no_such_file_or_directory, "opening " + path + ": no such file"});
    return std::make_unique<FakeDevice>(card_);
  }
  Result<std::unique_ptr<Scanout>> open_scanout(KmsDevice& device, int width, int height) override {
    auto context = open_headless_context();
    if (!context) return fail(context.error());
    auto picture = Offscreen::create((*context)->info(), width, height);
    if (!picture) return fail(picture.error());
    return std::make_unique<FakeScanout>(std::move(*context), std::move(*picture), device, card_);
  }
  Result<std::unique_ptr<DisplayWatch>> watch() override {
    if (!has_udev) return fail(FaultKind::unsupported, "no udev");
    return std::make_unique<FakeWatch>(card_);
  }
  std::string users_of(const std::string&) override { return users; }

 private:
  FakeCard& card_;
};

}  // namespace kasumi
