// A camera through libcamera: Raspberry Pi cameras and others whose picture is made from raw data on the host.
#pragma once

#include <string>
#include <vector>

#include "capture/camera_source.hpp"

namespace kasumi {

struct LibcameraOptions {
  std::string camera;  // its id, like "/base/soc/i2c0mux/i2c@1/imx477@1a"; the same at every boot
  CameraRequest request;
  friend bool operator==(const LibcameraOptions&, const LibcameraOptions&) = default;
};

// Errors as open_v4l2_source; `disconnected` when no camera of that id is there now. Only one process at a time has a
// camera.
Result<std::unique_ptr<CameraSource>> open_libcamera_source(const LibcameraOptions& options, Clock& clock);

struct LibcameraListing {
  std::string id;
  std::string model;  // "imx477"
};
// The cameras libcamera sees now. Error (unsupported): this build has no libcamera.
Result<std::vector<LibcameraListing>> list_libcamera_cameras();

}  // namespace kasumi
