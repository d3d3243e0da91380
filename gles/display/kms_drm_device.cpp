// libdrm behind kms_device.hpp.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <span>

#include <drm_fourcc.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/unique_fd.hpp"
#include "gles/display/kms_drm.hpp"
#include "gles/display/kms_edid.hpp"
#include "gles/display/kms_system.hpp"

namespace kasumi {
namespace {

static_assert(sizeof(drmModeModeInfo) == sizeof(KmsMode::timing));

KmsMode mode_of(const drmModeModeInfo& info) {
  KmsMode mode;
  mode.width = info.hdisplay;
  mode.height = info.vdisplay;
  mode.interlaced = (info.flags & DRM_MODE_FLAG_INTERLACE) != 0;
  mode.preferred = (info.type & DRM_MODE_TYPE_PREFERRED) != 0;
  const double per_refresh = static_cast<double>(info.htotal) * info.vtotal * (mode.interlaced ? 0.5 : 1.0) *
                             ((info.flags & DRM_MODE_FLAG_DBLSCAN) != 0 ? 2.0 : 1.0) * std::max<int>(info.vscan, 1);
  mode.refresh_hz = per_refresh > 0 ? 1e3 * info.clock / per_refresh : info.vrefresh;
  drmModeModeInfo timing = info;
  timing.type = 0;  // the preferred flag is not part of the timing
  std::memcpy(mode.timing.data(), &timing, sizeof timing);
  return mode;
}

drmModeModeInfo timing_of(const KmsMode& mode) {
  drmModeModeInfo info;
  std::memcpy(&info, mode.timing.data(), sizeof info);
  return info;
}

KmsConnection connection_of(drmModeConnection connection) {
  if (connection == DRM_MODE_CONNECTED) return KmsConnection::connected;
  return connection == DRM_MODE_DISCONNECTED ? KmsConnection::disconnected : KmsConnection::unknown;
}

class DrmDevice final : public KmsDevice {
 public:
  DrmDevice(std::string path, UniqueFd fd, std::string driver)
      : path_(std::move(path)), fd_(std::move(fd)), driver_(std::move(driver)), atomic_(fd_.value()) {
    std::error_code error;
    const auto node = std::filesystem::canonical(path_, error);
    sysfs_name_ = (error ? std::filesystem::path(path_) : node).filename().string();
    drmSetClientCap(fd_.value(), DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1);
    has_atomic_ = drmSetClientCap(fd_.value(), DRM_CLIENT_CAP_ATOMIC, 1) == 0;
    std::uint64_t value = 0;
    has_modifiers_ = drmGetCap(fd_.value(), DRM_CAP_ADDFB2_MODIFIERS, &value) == 0 && value != 0;
  }

  const std::string& path() const override { return path_; }
  const std::string& driver() const override { return driver_; }
  int fd() const override { return fd_.value(); }
  bool has_atomic() const override { return has_atomic_; }

  KmsResult<> become_master() override {
    // Opening a card without a master already makes the opener master.
    if (is_master() || drmSetMaster(fd_.value()) == 0) return {};
    return drm_error("becoming DRM master of {}", path_);
  }
  bool is_master() const override { return drmIsMaster(fd_.value()) != 0; }
  void drop_master() override { drmDropMaster(fd_.value()); }

  KmsResult<std::vector<KmsConnector>> connectors() override {
    const DrmResources resources(drmModeGetResources(fd_.value()));
    if (resources == nullptr) return drm_error("listing the outputs of {}", path_);
    std::vector<KmsConnector> found;
    for (const std::uint32_t id : std::span(resources->connectors, resources->count_connectors)) {
      auto one = connector(id);
      if (one) found.push_back(std::move(*one));  // a connector that disappears meanwhile is not an error
    }
    return found;
  }

  KmsResult<KmsConnector> connector(std::uint32_t id) override {
    const DrmResources resources(drmModeGetResources(fd_.value()));
    const DrmConnector raw(drmModeGetConnector(fd_.value(), id));
    if (resources == nullptr || raw == nullptr) return drm_error("querying connector {1} of {0}", path_, id);
    KmsConnector made;
    made.id = id;
    const char* type = drmModeGetConnectorTypeName(raw->connector_type);
    made.name = fmt::format("{}-{}", type == nullptr ? "Unknown" : type, raw->connector_type_id);
    made.connection = connection_of(raw->connection);
    for (const drmModeModeInfo& mode : std::span(raw->modes, raw->count_modes)) made.modes.push_back(mode_of(mode));
    for (const std::uint32_t encoder_id : std::span(raw->encoders, raw->count_encoders)) {
      const DrmEncoder encoder(drmModeGetEncoder(fd_.value(), encoder_id));
      if (encoder == nullptr) continue;
      for (int i = 0; i < std::min(resources->count_crtcs, 32); ++i) {
        const std::uint32_t crtc = resources->crtcs[i];
        if ((encoder->possible_crtcs >> i & 1u) != 0 && std::ranges::find(made.crtcs, crtc) == made.crtcs.end())
          made.crtcs.push_back(crtc);
      }
      if (encoder_id == raw->encoder_id) made.crtc = encoder->crtc_id;
    }
    const auto properties = drm_properties(fd_.value(), id, DRM_MODE_OBJECT_CONNECTOR);
    if (const auto crtc = properties.find("CRTC_ID"); crtc != properties.end())
      made.crtc = static_cast<std::uint32_t>(crtc->second.value);
    if (const DrmCrtc crtc(made.crtc == 0 ? nullptr : drmModeGetCrtc(fd_.value(), made.crtc)); crtc && crtc->mode_valid)
      made.mode_now = mode_of(crtc->mode);
    if (const auto link = properties.find("link-status"); link != properties.end())
      made.link_bad = link->second.value == DRM_MODE_LINK_STATUS_BAD;
    if (const auto edid = properties.find("EDID"); edid != properties.end() && edid->second.value != 0) {
      const DrmBlob blob(drmModeGetPropertyBlob(fd_.value(), static_cast<std::uint32_t>(edid->second.value)));
      if (blob != nullptr && blob->data != nullptr) {
        const std::span bytes(static_cast<const std::uint8_t*>(blob->data), blob->length);
        made.display = edid_name(bytes);
        made.identity = edid_identity(bytes);
      }
    }
    return made;
  }

  KmsConnection connection(const KmsConnector& connector) const override {
    // Reads sysfs, because ioctls block while the kernel probes a display.
    std::ifstream status(fmt::format("/sys/class/drm/{}-{}/status", sysfs_name_, connector.name));
    std::string word;
    if (status >> word)
      return word == "connected"      ? KmsConnection::connected
             : word == "disconnected" ? KmsConnection::disconnected
                                      : KmsConnection::unknown;
    const DrmConnector raw(drmModeGetConnectorCurrent(fd_.value(), connector.id));
    return raw == nullptr ? KmsConnection::disconnected : connection_of(raw->connection);
  }

  KmsResult<KmsPipe> find_pipe(const KmsConnector& connector, const KmsMode& mode) override {
    const DrmResources resources(drmModeGetResources(fd_.value()));
    if (resources == nullptr) return drm_error("listing the CRTCs of {}", path_);
    for (const std::uint32_t crtc : by_preference(connector, *resources)) {
      const std::span crtcs(resources->crtcs, resources->count_crtcs);
      const auto index = std::ranges::find(crtcs, crtc) - crtcs.begin();
      const std::uint32_t plane = primary_plane(crtc, static_cast<int>(index));
      if (plane != 0 || !has_atomic_) return KmsPipe{connector.id, crtc, plane, mode};
    }
    errno = EBUSY;
    return drm_error("finding a CRTC of {} for {}", path_, connector.name);
  }

  KmsResult<std::vector<KmsPlane>> planes(const KmsPipe& pipe) override {
    const DrmResources resources(drmModeGetResources(fd_.value()));
    const DrmPlanes all(drmModeGetPlaneResources(fd_.value()));
    if (resources == nullptr || all == nullptr) return drm_error("listing the planes of {}", path_);
    const std::span crtcs(resources->crtcs, resources->count_crtcs);
    const auto index = std::ranges::find(crtcs, pipe.crtc) - crtcs.begin();
    std::vector<KmsPlane> found;
    for (const std::uint32_t id : std::span(all->planes, all->count_planes)) {
      const DrmPlane raw(drmModeGetPlane(fd_.value(), id));
      if (raw == nullptr || index >= 32 || (raw->possible_crtcs >> index & 1u) == 0) continue;
      found.push_back(described(*raw, pipe.crtc));
    }
    return found;
  }

  KmsResult<std::uint32_t> add_framebuffer(const KmsBuffer& buffer) override {
    if (buffer.dma_buf >= 0) return add_foreign(buffer);
    return add_framebuffer(fd_.value(), buffer);
  }
  void remove_framebuffer(std::uint32_t framebuffer) override {
    const bool foreign = foreign_.erase(framebuffer) > 0;
    drmModeRmFB(foreign ? foreign_fd_.value() : fd_.value(), framebuffer);
  }

  KmsResult<> commit_mode(const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait) override {
    return atomic_.commit_mode(path_, pipe, frame, wait);
  }
  KmsResult<> commit_flip(const KmsPipe& pipe, const KmsFrame& frame) override {
    return atomic_.commit_flip(path_, pipe, frame);
  }
  KmsResult<> commit_planes(const KmsPipe& pipe, std::span<const KmsPlaneState> planes, std::uint64_t number,
                            KmsTrial trial) override {
    return atomic_.commit_planes(path_, pipe, planes, number, trial);
  }
  KmsResult<> set_crtc(const KmsPipe& pipe, const KmsFrame& frame) override {
    std::uint32_t connector = pipe.connector;
    drmModeModeInfo mode = timing_of(pipe.mode);
    if (drmModeSetCrtc(fd_.value(), pipe.crtc, frame.framebuffer, 0, 0, &connector, 1, &mode) != 0)
      return drm_error("setting the mode (legacy) on {}", path_);
    return {};
  }
  KmsResult<> page_flip(const KmsPipe& pipe, const KmsFrame& frame) override {
    auto* user_data = reinterpret_cast<void*>(static_cast<std::uintptr_t>(frame.number));
    if (drmModePageFlip(fd_.value(), pipe.crtc, frame.framebuffer, DRM_MODE_PAGE_FLIP_EVENT, user_data) != 0)
      return drm_error("page flip (legacy) on {}", path_);
    return {};
  }

  KmsResult<> turn_off(const KmsPipe& pipe, bool atomic) override {
    if (atomic) return atomic_.commit_off(path_, pipe);
    if (drmModeSetCrtc(fd_.value(), pipe.crtc, 0, 0, 0, nullptr, 0, nullptr) != 0)
      return drm_error("turning the display off (legacy) on {}", path_);
    return {};
  }

  KmsResult<std::vector<KmsEvent>> wait_events(Duration at_most) override {
    pollfd polled{fd_.value(), POLLIN, 0};
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(at_most);
    const timespec timeout{seconds.count(), (at_most - seconds).count()};
    const int ready = ppoll(&polled, 1, &timeout, nullptr);
    if (ready < 0 && errno != EINTR) return drm_error("waiting for {}", path_);
    if (ready <= 0) return std::vector<KmsEvent>{};
    if ((polled.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (polled.revents & POLLIN) == 0) {
      errno = ENODEV;
      return drm_error("waiting for {}", path_);
    }
    alignas(drm_event_vblank) std::array<std::uint8_t, 1024> bytes{};
    const ssize_t got = read(fd_.value(), bytes.data(), bytes.size());
    if (got < 0 && errno != EAGAIN && errno != EINTR) return drm_error("reading the events of {}", path_);
    return events_in(std::span(bytes).first(got < 0 ? 0 : static_cast<std::size_t>(got)));
  }

  void remember(const KmsPipe& pipe) override {
    console_.reset(drmModeGetCrtc(fd_.value(), pipe.crtc));
    console_connector_ = pipe.connector;
  }
  void restore() override {
    if (console_ == nullptr || console_->buffer_id == 0 || console_->mode_valid == 0) return;
    drmModeSetCrtc(fd_.value(), console_->crtc_id, console_->buffer_id, console_->x, console_->y, &console_connector_,
                   1, &console_->mode);
  }

 private:
  // First the CRTC that already drives the connector, to avoid flicker; then unused ones; last those of other
  // connectors.
  std::vector<std::uint32_t> by_preference(const KmsConnector& connector, const drmModeRes& resources) const {
    std::vector<std::uint32_t> taken;
    for (const std::uint32_t id : std::span(resources.connectors, resources.count_connectors)) {
      if (id == connector.id) continue;
      const DrmConnector other(drmModeGetConnectorCurrent(fd_.value(), id));
      if (other == nullptr || other->encoder_id == 0) continue;
      const DrmEncoder encoder(drmModeGetEncoder(fd_.value(), other->encoder_id));
      if (encoder != nullptr && encoder->crtc_id != 0) taken.push_back(encoder->crtc_id);
    }
    std::vector<std::uint32_t> ordered = connector.crtcs;
    std::ranges::stable_sort(ordered, {}, [&](std::uint32_t crtc) {
      if (crtc == connector.crtc) return 0;
      return std::ranges::find(taken, crtc) == taken.end() ? 1 : 2;
    });
    return ordered;
  }

  // 0: no primary plane supports XRGB8888.
  std::uint32_t primary_plane(std::uint32_t crtc, int crtc_index) const {
    const DrmPlanes planes(drmModeGetPlaneResources(fd_.value()));
    if (planes == nullptr || crtc_index < 0 || crtc_index >= 32) return 0;
    std::uint32_t found = 0;
    for (const std::uint32_t id : std::span(planes->planes, planes->count_planes)) {
      const DrmPlane plane(drmModeGetPlane(fd_.value(), id));
      if (plane == nullptr || (plane->possible_crtcs >> crtc_index & 1u) == 0) continue;
      const std::span formats(plane->formats, plane->count_formats);
      if (std::ranges::find(formats, DRM_FORMAT_XRGB8888) == formats.end()) continue;
      const auto properties = drm_properties(fd_.value(), id, DRM_MODE_OBJECT_PLANE);
      const auto type = properties.find("type");
      if (type == properties.end() || type->second.value != DRM_PLANE_TYPE_PRIMARY) continue;
      if (plane->crtc_id == crtc) return id;
      if (found == 0 && plane->crtc_id == 0) found = id;
    }
    return found;
  }

  KmsPlane described(const drmModePlane& raw, std::uint32_t crtc) const {
    KmsPlane plane;
    plane.id = raw.plane_id;
    plane.free = raw.crtc_id == 0 || raw.crtc_id == crtc;
    plane.formats.assign(raw.formats, raw.formats + raw.count_formats);
    const auto properties = drm_properties(fd_.value(), plane.id, DRM_MODE_OBJECT_PLANE);
    const auto find = [&](const char* name) {
      const auto place = properties.find(name);
      return place == properties.end() ? nullptr : &place->second;
    };
    if (const auto* type = find("type"))
      plane.kind = type->value == DRM_PLANE_TYPE_PRIMARY  ? KmsPlane::Kind::primary
                   : type->value == DRM_PLANE_TYPE_CURSOR ? KmsPlane::Kind::cursor
                                                          : KmsPlane::Kind::overlay;
    if (const auto* zpos = find("zpos")) plane.zpos = KmsPlane::Zpos{zpos->value, zpos->least, zpos->most, zpos->fixed};
    if (const auto* blend = find("pixel blend mode")) plane.premultiplied = blend->choices.contains("Pre-multiplied");
    const auto *encoding = find("COLOR_ENCODING"), *range = find("COLOR_RANGE");
    if (encoding == nullptr || range == nullptr) return plane;
    for (const auto one :
         {YuvEncoding::bt601_full, YuvEncoding::bt601_limited, YuvEncoding::bt709_full, YuvEncoding::bt709_limited}) {
      const auto names = drm_yuv_names(one);
      if (encoding->choices.contains(names.encoding) && range->choices.contains(names.range))
        plane.encodings.push_back(one);
    }
    return plane;
  }

  KmsResult<std::uint32_t> add_framebuffer(int fd, const KmsBuffer& buffer) const {
    std::uint32_t id = 0;
    const auto width = static_cast<std::uint32_t>(buffer.width), height = static_cast<std::uint32_t>(buffer.height);
    if (has_modifiers_ && buffer.has_modifier) {
      std::array<std::uint64_t, 4> modifiers{};
      for (int i = 0; i < buffer.planes; ++i) modifiers[static_cast<std::size_t>(i)] = buffer.modifier;
      if (drmModeAddFB2WithModifiers(fd, width, height, buffer.format, buffer.handle.data(), buffer.stride.data(),
                                     buffer.offset.data(), modifiers.data(), &id, DRM_MODE_FB_MODIFIERS) == 0)
        return id;
    }
    if (drmModeAddFB2(fd, width, height, buffer.format, buffer.handle.data(), buffer.stride.data(),
                      buffer.offset.data(), &id, 0) != 0)
      return drm_error("adding a framebuffer of {}x{} ({}) to {}", width, height, drm_format_text(buffer.format),
                       path_);
    return id;
  }

  // Handles are counted per opening of the card, but not per import, and GBM closes those that it shares: other
  // drivers' buffers get an opening of their own. The framebuffer keeps the buffer.
  KmsResult<std::uint32_t> add_foreign(const KmsBuffer& buffer) {
    if (!foreign_fd_) foreign_fd_ = UniqueFd(open(path_.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (!foreign_fd_) return drm_error("opening {} for the camera's buffers", path_);
    std::uint32_t handle = 0;
    if (drmPrimeFDToHandle(foreign_fd_.value(), buffer.dma_buf, &handle) != 0)
      return drm_error("importing the camera's buffer into {}", path_);
    KmsBuffer imported = buffer;
    std::fill_n(imported.handle.begin(), imported.planes, handle);
    auto id = add_framebuffer(foreign_fd_.value(), imported);
    drmCloseBufferHandle(foreign_fd_.value(), handle);
    if (id) foreign_.insert(*id);
    return id;
  }

  static std::vector<KmsEvent> events_in(std::span<const std::uint8_t> bytes) {
    std::vector<KmsEvent> events;
    while (bytes.size() >= sizeof(drm_event)) {
      drm_event head;
      std::memcpy(&head, bytes.data(), sizeof head);
      if (head.length < sizeof head || head.length > bytes.size()) break;
      if (head.type == DRM_EVENT_FLIP_COMPLETE && head.length >= sizeof(drm_event_vblank)) {
        drm_event_vblank flip;
        std::memcpy(&flip, bytes.data(), sizeof flip);
        events.push_back({flip.user_data, Instant(std::chrono::seconds(flip.tv_sec)) +
                                              Duration(std::chrono::microseconds(flip.tv_usec))});
      }
      bytes = bytes.subspan(head.length);
    }
    return events;
  }

  std::string path_;
  UniqueFd fd_;
  UniqueFd foreign_fd_;              // the card opened again, for the buffers of other drivers
  std::set<std::uint32_t> foreign_;  // framebuffers of these
  std::string driver_;
  std::string sysfs_name_;  // "card0"
  DrmAtomic atomic_;
  bool has_atomic_ = false;
  bool has_modifiers_ = false;
  DrmCrtc console_;
  std::uint32_t console_connector_ = 0;
};

}  // namespace

KmsResult<std::unique_ptr<KmsDevice>> open_drm_device(const std::string& path) {
  UniqueFd fd(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!fd) return drm_error("opening {}", path);
  const DrmResources resources(drmModeGetResources(fd.value()));
  if (resources == nullptr || resources->count_crtcs == 0 || resources->count_connectors == 0) {
    errno = EOPNOTSUPP;
    return drm_error("{} drives no displays", path);
  }
  const CPtr<drmVersion, drmFreeVersion> version(drmGetVersion(fd.value()));
  std::string driver = version == nullptr || version->name == nullptr
                           ? "unknown driver"
                           : std::string(version->name, static_cast<std::size_t>(std::max(version->name_len, 0)));
  return std::make_unique<DrmDevice>(path, std::move(fd), std::move(driver));
}

}  // namespace kasumi
