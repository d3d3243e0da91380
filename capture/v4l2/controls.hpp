// Exposure, gain and white balance: set, locked, read back.
#pragma once

#include "capture/camera_source.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

// Locks what the request names and leaves the rest to the camera. The values the driver set go into `mode`, refusals
// into mode.notes. Error (disconnected): the device is unplugged.
Result<> set_v4l2_controls(VideoDevice& device, const CameraRequest& request, CameraMode& mode);

// Locks white balance at its current value.
Result<> lock_v4l2_white_balance(VideoDevice& device, CameraMode& mode);

}  // namespace kasumi
