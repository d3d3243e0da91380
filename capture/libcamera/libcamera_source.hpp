// Cameras through libcamera: Raspberry Pi cameras and others whose raw data is processed on the host.
#pragma once

#include <string>
#include <vector>

#include "capture/camera_source.hpp"

namespace kasumi {

struct LibcameraOptions {
  std::string camera;  // its id, like "/base/soc/i2c0mux/i2c@1/imx477@1a"; stable across boots
  CameraRequest request;
  friend bool operator==(const LibcameraOptions&, const LibcameraOptions&) = default;
};

// Errors as open_v4l2_source; `disconnected` when there is no camera with that id. A camera can be used by only one
// process at a time.
Result<std::unique_ptr<CameraSource>> open_libcamera_source(const LibcameraOptions& options, Clock& clock);

// Whether libcamera sees it now. Cheap: the manager follows hotplugging. false before the first opening.
bool is_libcamera_camera_present(const std::string& camera);

struct LibcameraListing {
  std::string id;
  std::string model;  // "imx477"
};
// The cameras libcamera finds now. Error (unsupported): this build has no libcamera.
Result<std::vector<LibcameraListing>> list_libcamera_cameras();

}  // namespace kasumi
