// The kernel modesetting interface used by the KMS display, which tests can replace. Nothing a driver reports is
// trusted by its users: numbers are looked up, times are bounded.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include <tl/expected.hpp>

#include "base/clock.hpp"
#include "base/picture.hpp"
#include "gles/picture/drm_format.hpp"

namespace kasumi {

// Why the kernel refused.
struct KmsError {
  std::errc code{};
  std::string what;  // "page flip on /dev/dri/card0: Device or resource busy"
};
template <class T = void>
using KmsResult = tl::expected<T, KmsError>;

inline tl::unexpected<KmsError> fail(KmsError error) {
  return tl::unexpected<KmsError>(std::move(error));
}

struct KmsMode {
  int width = 0;  // pixels
  int height = 0;
  double refresh_hz = 0.0;
  bool preferred = false;  // by the display itself
  bool interlaced = false;
  std::array<std::uint8_t, 68> timing{};  // the kernel's own structure, passed back unchanged
  // "1920x1080@59.94", "1920x1080i@50.00"
  std::string text() const;
  bool same_timing(const KmsMode& other) const { return timing == other.timing; }
};

enum class KmsConnection { connected, disconnected, unknown };

struct KmsConnector {
  std::uint32_t id = 0;
  std::string name;  // "HDMI-A-1"
  KmsConnection connection = KmsConnection::unknown;
  std::vector<KmsMode> modes;        // may be empty although a display is connected
  std::vector<std::uint32_t> crtcs;  // those that can drive it
  std::uint32_t crtc = 0;            // the one that drives it now; 0: none
  std::optional<KmsMode> mode_now;   // that CRTC's
  std::string display;               // "DEL U2412M", by its EDID; empty: unknown
  std::uint64_t identity = 0;        // changes with the display's EDID; 0: no EDID
  bool link_bad = false;             // the driver needs another modeset to retrain the link
};

// What drives the display.
struct KmsPipe {
  std::uint32_t connector = 0;
  std::uint32_t crtc = 0;
  std::uint32_t plane = 0;  // the CRTC's primary plane
  KmsMode mode;
};

// A buffer in the card's memory, or in memory that it can read.
struct KmsBuffer {
  int width = 0;
  int height = 0;
  std::uint32_t format = drm_format("XR24");
  std::uint64_t modifier = 0;  // meaningful when has_modifier
  bool has_modifier = false;
  int planes = 1;  // 1 .. 4
  std::array<std::uint32_t, 4> handle{};
  int dma_buf = -1;  // of another driver, instead of handles; used only while the framebuffer is added
  std::array<std::uint32_t, 4> stride{};
  std::array<std::uint32_t, 4> offset{};
};

struct KmsFrame {
  std::uint32_t framebuffer = 0;
  std::uint64_t number = 0;  // returned with the event
};

// What scans out a framebuffer over or under others.
struct KmsPlane {
  enum class Kind { primary, overlay, cursor };
  struct Zpos {  // the higher one lies above
    std::uint64_t now = 0, least = 0, most = 0;
    bool fixed = false;
  };
  std::uint32_t id = 0;
  Kind kind = Kind::overlay;
  bool free = true;                    // no other CRTC uses it
  std::vector<std::uint32_t> formats;  // drm_format()
  std::optional<Zpos> zpos;            // empty: the driver does not say
  std::optional<bool> premultiplied;   // whether it can blend so; empty: the driver does not say
  std::vector<YuvEncoding> encodings;  // that it can convert
};

struct KmsRectangle {  // pixels
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  friend bool operator==(const KmsRectangle&, const KmsRectangle&) = default;
};

// What one plane shows, unscaled.
struct KmsPlaneState {
  std::uint32_t plane = 0;
  std::uint32_t framebuffer = 0;  // 0: nothing
  KmsRectangle source{};          // of the framebuffer
  int x = 0;                      // of its top left corner on the screen
  int y = 0;
  std::optional<std::uint64_t> zpos{};    // empty: as it is
  std::optional<YuvEncoding> encoding{};  // empty: not YUV
  bool blends = false;                    // premultiplied, over what lies below
};

struct KmsEvent {
  std::uint64_t number = 0;
  Instant at{};  // CLOCK_MONOTONIC
};

enum class KmsWait { for_the_hardware, no };
enum class KmsTrial { only_ask, no };

class KmsDevice {
 public:
  virtual ~KmsDevice() = default;
  virtual const std::string& path() const = 0;    // "/dev/dri/card0"
  virtual const std::string& driver() const = 0;  // "virtio_gpu"
  virtual int fd() const = 0;                     // for allocating its buffers
  virtual bool has_atomic() const = 0;

  virtual KmsResult<> become_master() = 0;
  virtual bool is_master() const = 0;
  virtual void drop_master() = 0;  // for read-only use: opening a card without a master makes the opener master

  // Probes the displays: BLOCKS for some 10 ms each.
  virtual KmsResult<std::vector<KmsConnector>> connectors() = 0;
  virtual KmsResult<KmsConnector> connector(std::uint32_t id) = 0;
  // The kernel's cached state. Cheap.
  virtual KmsConnection connection(const KmsConnector& connector) const = 0;
  // A CRTC and its primary plane for the connector: those that drive it now, else free ones if there are any.
  virtual KmsResult<KmsPipe> find_pipe(const KmsConnector& connector, const KmsMode& mode) = 0;

  // Those that can show something on the pipe's CRTC.
  virtual KmsResult<std::vector<KmsPlane>> planes(const KmsPipe& pipe) = 0;

  // Owned by KmsFramebuffer.
  virtual KmsResult<std::uint32_t> add_framebuffer(const KmsBuffer& buffer) = 0;
  virtual void remove_framebuffer(std::uint32_t framebuffer) = 0;

  // Atomic commits; each sends an event when the picture is on screen. commit_mode may do a full modeset.
  virtual KmsResult<> commit_mode(const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait) = 0;
  virtual KmsResult<> commit_flip(const KmsPipe& pipe, const KmsFrame& frame) = 0;
  // All at once, without a modeset; planes that are not named stay as they are.
  virtual KmsResult<> commit_planes(const KmsPipe& pipe, std::span<const KmsPlaneState> planes, std::uint64_t number,
                                    KmsTrial trial) = 0;
  // The legacy calls. set_crtc BLOCKS until the picture is on screen and sends no event; page_flip sends one.
  virtual KmsResult<> set_crtc(const KmsPipe& pipe, const KmsFrame& frame) = 0;
  virtual KmsResult<> page_flip(const KmsPipe& pipe, const KmsFrame& frame) = 0;

  // Disables the CRTC, so that the display goes to sleep; setting a mode wakes it. BLOCKS until done.
  virtual KmsResult<> turn_off(const KmsPipe& pipe, bool atomic) = 0;

  // BLOCKS until an event arrives or this time has passed. No event is not an error.
  virtual KmsResult<std::vector<KmsEvent>> wait_events(Duration at_most) = 0;

  // Saves what the CRTC shows now, for restore(). Does nothing if it shows nothing.
  virtual void remember(const KmsPipe& pipe) = 0;
  virtual void restore() = 0;
};

// Owns a framebuffer on the card; the card must outlive it.
class KmsFramebuffer {
 public:
  static KmsResult<KmsFramebuffer> add(KmsDevice& device, const KmsBuffer& buffer);
  KmsFramebuffer(KmsFramebuffer&& other) noexcept;
  KmsFramebuffer& operator=(KmsFramebuffer&& other) noexcept;
  KmsFramebuffer(const KmsFramebuffer&) = delete;
  KmsFramebuffer& operator=(const KmsFramebuffer&) = delete;
  ~KmsFramebuffer();
  std::uint32_t id() const { return id_; }

 private:
  KmsFramebuffer(KmsDevice& device, std::uint32_t id) : device_(&device), id_(id) {}
  KmsDevice* device_;
  std::uint32_t id_;  // 0: moved from
};

}  // namespace kasumi
