// A camera through Video4Linux 2: webcams, capture cards, vivid, v4l2loopback.
#pragma once

#include <filesystem>

#include "capture/camera_source.hpp"

namespace kasumi {

struct V4l2Options {
  std::filesystem::path device;  // "/dev/v4l/by-id/usb-046d_HD_Pro_Webcam_C920-video-index0"; a number may name another
                                 // camera after the next boot
  CameraRequest request;
  friend bool operator==(const V4l2Options&, const V4l2Options&) = default;
};

// Single- and multi-planar capture with mapped buffers, exported as dma-bufs where the driver can. The device is opened
// without blocking; next() waits by poll until its deadline and gives the newest frame there is, older ones go back to
// the driver and are counted as dropped. Nothing the driver answers is believed unchecked: index, size, stride, bytes.
// Errors: disconnected (no such device now), bad_input (what was asked for cannot be had: everything at once, with what
// the camera offers), device (the driver refuses: which call, which reason), unsupported (not a capture device).
Result<std::unique_ptr<CameraSource>> open_v4l2_source(const V4l2Options& options, Clock& clock);

}  // namespace kasumi
