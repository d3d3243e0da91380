// The kernel's modesetting as the KMS display sees it: the one door to the driver, behind which tests can stand.
// Nothing a driver answers is believed beyond this door: numbers are looked up, times are bounded.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <tl/expected.hpp>

#include "base/clock.hpp"

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
  std::array<std::uint8_t, 68> timing{};  // the kernel's own words, handed back as they came
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
  std::vector<std::uint32_t> crtcs;  // those that can feed it
  std::uint32_t crtc = 0;            // the one that feeds it now; 0: none
  std::optional<KmsMode> mode_now;   // that CRTC's
  std::string display;               // "DEL U2412M", by its EDID; empty: it does not say
  std::uint64_t identity = 0;        // changes with the display's EDID; 0: it has none
  bool link_bad = false;             // the driver wants the mode set again to train the link
};

// What feeds the display.
struct KmsPipe {
  std::uint32_t connector = 0;
  std::uint32_t crtc = 0;
  std::uint32_t plane = 0;  // the CRTC's primary plane
  KmsMode mode;
};

// A picture in the card's memory.
struct KmsBuffer {
  int width = 0;
  int height = 0;
  std::uint64_t modifier = 0;  // meaningful when has_modifier
  bool has_modifier = false;
  int planes = 1;  // 1 .. 4
  std::array<std::uint32_t, 4> handle{};
  std::array<std::uint32_t, 4> stride{};
  std::array<std::uint32_t, 4> offset{};
};

struct KmsFrame {
  std::uint32_t framebuffer = 0;
  std::uint64_t number = 0;  // comes back with the event
};

struct KmsEvent {
  std::uint64_t number = 0;
  Instant at{};  // CLOCK_MONOTONIC
};

enum class KmsWait { for_the_hardware, no };

class KmsDevice {
 public:
  virtual ~KmsDevice() = default;
  virtual const std::string& path() const = 0;    // "/dev/dri/card0"
  virtual const std::string& driver() const = 0;  // "virtio_gpu"
  virtual int fd() const = 0;                     // for who allocates its buffers
  virtual bool has_atomic() const = 0;

  virtual KmsResult<> become_master() = 0;
  virtual bool is_master() const = 0;
  virtual void drop_master() = 0;  // for who only looks: opening a card that has no master makes one master

  // Ask the displays themselves: BLOCKS for some 10 ms each.
  virtual KmsResult<std::vector<KmsConnector>> connectors() = 0;
  virtual KmsResult<KmsConnector> connector(std::uint32_t id) = 0;
  // What the kernel knows already. Cheap.
  virtual KmsConnection connection(const KmsConnector& connector) const = 0;
  // A CRTC and its primary plane for the connector: the ones that feed it now, or free ones.
  virtual KmsResult<KmsPipe> find_pipe(const KmsConnector& connector, const KmsMode& mode) = 0;

  // XRGB8888. The owner is KmsFramebuffer.
  virtual KmsResult<std::uint32_t> add_framebuffer(const KmsBuffer& buffer) = 0;
  virtual void remove_framebuffer(std::uint32_t framebuffer) = 0;

  // Atomic commits; each answers with an event when the picture is on the glass. commit_mode may change everything.
  virtual KmsResult<> commit_mode(const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait) = 0;
  virtual KmsResult<> commit_flip(const KmsPipe& pipe, const KmsFrame& frame) = 0;
  // The legacy calls. set_crtc BLOCKS until the picture is on the glass, and sends no event; page_flip sends one.
  virtual KmsResult<> set_crtc(const KmsPipe& pipe, const KmsFrame& frame) = 0;
  virtual KmsResult<> page_flip(const KmsPipe& pipe, const KmsFrame& frame) = 0;

  // The CRTC feeds the display no more: it goes to sleep. Setting a mode wakes it. BLOCKS until it is so.
  virtual KmsResult<> turn_off(const KmsPipe& pipe, bool atomic) = 0;

  // BLOCKS until an event comes, or for so long. No event is no error.
  virtual KmsResult<std::vector<KmsEvent>> wait_events(Duration at_most) = 0;

  // What the CRTC shows now, to be given back by restore(). Does nothing where it shows nothing.
  virtual void remember(const KmsPipe& pipe) = 0;
  virtual void restore() = 0;
};

// Removes its framebuffer from the card; the card outlives it.
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
