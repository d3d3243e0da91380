// A camera through Video4Linux 2: webcams, capture cards, vivid, v4l2loopback.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/camera_source.hpp"

namespace kasumi {

class VideoDevice;

struct V4l2Options {
  std::filesystem::path device;  // "/dev/v4l/by-id/usb-046d_HD_Pro_Webcam_C920-video-index0"; a number may name another
                                 // camera after the next boot
  CameraRequest request;
  friend bool operator==(const V4l2Options&, const V4l2Options&) = default;
};

// Single- and multi-planar capture with mapped buffers, exported as dma-bufs if the driver can. The device is opened
// non-blocking; next() polls until its deadline and returns the newest frame, while older ones go back to the driver
// and are counted as skipped. Everything the driver reports is checked: index, size, stride, bytes. Deviations from the
// request (rate, controls) are listed in mode().notes. Gain has no unit in V4L2: it is the driver's own number, and
// frames carry none.
// Errors: disconnected (no such device now), bad_input (the request cannot be met: all problems, with what the camera
// offers), device (the driver refuses: which call, and why), unsupported (not a capture device). Additional errors of
// next(): device, disconnected. Both are permanent: the source must be opened again.
Result<std::unique_ptr<CameraSource>> open_v4l2_source(const V4l2Options& options, Clock& clock);
// The same on a device that is already open.
Result<std::unique_ptr<CameraSource>> open_v4l2_source(std::unique_ptr<VideoDevice> device, const V4l2Options& options,
                                                       Clock& clock);

struct V4l2Listing {
  std::filesystem::path node;                       // "/dev/video0"
  std::vector<std::filesystem::path> stable_paths;  // by-id first; use one of these in a configuration
  std::string driver;
  std::string card;
  std::string place;
  std::vector<std::string> formats;  // "YUYV: 640x480 (30, 15 /s), 1280x720 (10 /s)"; only those Kasumi reads
  std::string problem;               // why it could not be queried; empty if it could
};
// The capture devices present now, by number. Opens each briefly, which does not disturb other programs' streams.
std::vector<V4l2Listing> list_v4l2_cameras(const std::filesystem::path& devices = "/dev");

}  // namespace kasumi
