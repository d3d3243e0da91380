// A live camera: the mode requested of it, and the mode its driver set.
#pragma once

#include <optional>
#include <string>

#include "capture/frame_source.hpp"

namespace kasumi {

struct CameraRequest {
  std::optional<FourCc> format{};  // empty: the cheapest to process of those the camera offers and Kasumi reads
  int width = 0;                   // pixels; the driver must give exactly this size
  int height = 0;
  double frames_per_second = 0.0;             // 0: the camera's highest rate
  std::optional<double> exposure_s{};         // locked there; empty: the camera's own choice
  std::optional<double> gain{};               // factor, 1 = none; locked there
  std::optional<double> white_balance_k{};    // locked there
  bool lock_white_balance = true;             // without a temperature: at its value after the first frames
  std::optional<YuvEncoding> yuv_encoding{};  // from calibration, overrides the driver's; a difference is noted
  // 3 .. 16. Two stay with the driver; the others can be lent: one waiting, one being drawn, one queued to flip, one
  // shown.
  int buffers = 6;
  // Frames stay in the driver's buffers until they are released; false: each frame is copied.
  bool lend_buffers = true;
  friend bool operator==(const CameraRequest&, const CameraRequest&) = default;
};

// The negotiated mode, read back from the driver.
struct CameraMode {
  FourCc format{};
  int width = 0;
  int height = 0;
  std::uint32_t stride = 0;        // bytes, of the first plane
  double frames_per_second = 0.0;  // 0: not reported by the driver
  std::optional<double> exposure_s{};
  std::optional<double> gain{};
  std::optional<double> white_balance_k{};
  std::optional<YuvEncoding> yuv_encoding{};  // as the driver reports it; empty: RGB, grey, or not reported
  std::string driver;                         // "uvcvideo"
  std::string card;                           // "HD Pro Webcam C920"
  std::string place;                          // "usb-0000:00:14.0-2"; distinguishes identical cameras
  std::vector<std::string> notes;             // requests that the driver did not fulfil, as messages
  friend bool operator==(const CameraMode&, const CameraMode&) = default;
};

// A lent frame keeps the device open: release all frames when the source returns `disconnected`.
class CameraSource : public FrameSource {
 public:
  // May change between calls of next(), because white balance is locked only after it has settled.
  virtual const CameraMode& mode() const = 0;
  // Frames copied out of the driver's memory because of lend_buffers or too few buffers. From any thread.
  virtual std::uint64_t frames_copied() const = 0;
};

}  // namespace kasumi
