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

// Single- and multi-planar capture with mapped buffers, exported as dma-bufs where the driver can. The device is opened
// without blocking; next() waits by poll until its deadline and gives the newest frame there is, older ones go back to
// the driver and are counted as skipped. Nothing the driver answers is believed unchecked: index, size, stride, bytes.
// What could be had only otherwise (rate, controls) is said in mode().notes. Gain has no unit in V4L2: it is the
// driver's own number, and frames carry none.
// Errors: disconnected (no such device now), bad_input (what was asked for cannot be had: everything at once, with what
// the camera offers), device (the driver refuses: which call, which reason), unsupported (not a capture device).
// Errors of next() besides: device, disconnected: for good, the source has to be opened anew.
Result<std::unique_ptr<CameraSource>> open_v4l2_source(const V4l2Options& options, Clock& clock);
// The same on a device that is open already.
Result<std::unique_ptr<CameraSource>> open_v4l2_source(std::unique_ptr<VideoDevice> device, const V4l2Options& options,
                                                       Clock& clock);

struct V4l2Listing {
  std::filesystem::path node;                       // "/dev/video0"
  std::vector<std::filesystem::path> stable_paths;  // by-id first; what belongs into a configuration
  std::string driver;
  std::string card;
  std::string place;
  std::vector<std::string> formats;  // "YUYV: 640x480 (30, 15 /s), 1280x720 (10 /s)"; only those Kasumi reads
  std::string problem;               // why it could not be asked; empty: it could
};
// The capture devices there are now, by number. Opens each for a moment, which does not disturb who streams from it.
std::vector<V4l2Listing> list_v4l2_cameras(const std::filesystem::path& devices = "/dev");

}  // namespace kasumi
