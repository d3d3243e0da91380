// Exposure, gain and white balance: set, locked, read back.
#pragma once

#include "capture/camera_source.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

// Locks what the request names, leaves the rest to the camera. What the driver made of it goes into `mode`, what it
// would not do into mode.notes. Error (disconnected): the device is gone.
Result<> set_v4l2_controls(VideoDevice& device, const CameraRequest& request, CameraMode& mode);

// Locks white balance where it stands now.
Result<> lock_v4l2_white_balance(VideoDevice& device, CameraMode& mode);

}  // namespace kasumi
