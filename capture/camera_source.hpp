// A live camera: what is asked of it, and what its driver made of that.
#pragma once

#include <optional>
#include <string>

#include "capture/frame_source.hpp"

namespace kasumi {

struct CameraRequest {
  std::optional<FourCc> format{};  // empty: the one that costs least to take, of those the camera offers and we read
  int width = 0;                   // pixels; what the driver makes of it must be exactly this
  int height = 0;
  double frames_per_second = 0.0;             // 0: as fast as the camera will
  std::optional<double> exposure_s{};         // locked there; empty: the camera's own choice
  std::optional<double> gain{};               // factor, 1 = none; locked there
  std::optional<double> white_balance_k{};    // locked there
  bool lock_white_balance = true;             // without a temperature: where it stands after the first frames
  std::optional<YuvEncoding> yuv_encoding{};  // calibration's word, which counts; that a driver says otherwise is noted
  // 3 .. 16. Two stay with the driver, the others can be lent: one waits, one is drawn, one is flipped to, one is seen.
  int buffers = 6;
  // Frames lie in the driver's buffers until they are let go; false: each frame is copied out.
  bool lend_buffers = true;
  friend bool operator==(const CameraRequest&, const CameraRequest&) = default;
};

// What was agreed on, read back from the driver.
struct CameraMode {
  FourCc format{};
  int width = 0;
  int height = 0;
  std::uint32_t stride = 0;        // bytes, of the first plane
  double frames_per_second = 0.0;  // 0: the driver does not say
  std::optional<double> exposure_s{};
  std::optional<double> gain{};
  std::optional<double> white_balance_k{};
  std::optional<YuvEncoding> yuv_encoding{};  // as the driver reports it; empty: RGB, grey, or it does not say
  std::string driver;                         // "uvcvideo"
  std::string card;                           // "HD Pro Webcam C920"
  std::string place;                          // "usb-0000:00:14.0-2"; tells two equal cameras apart
  std::vector<std::string> notes;             // what was asked for and the driver would not give, in words
  friend bool operator==(const CameraMode&, const CameraMode&) = default;
};

// A frame that is lent keeps the device open: let go of all of them when the source answers `disconnected`.
class CameraSource : public FrameSource {
 public:
  // May change between two calls of next(): white balance is locked only when it has settled.
  virtual const CameraMode& mode() const = 0;
  // Out of the driver's memory, by lend_buffers or for want of buffers. From any thread.
  virtual std::uint64_t frames_copied() const = 0;
};

}  // namespace kasumi
