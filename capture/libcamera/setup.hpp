// What is asked of a libcamera camera: its stream's format and size, its controls.
#pragma once

#include <memory>

#include <libcamera/libcamera.h>

#include "capture/camera_source.hpp"

namespace kasumi {

// The stream's configuration, validated, in the format that costs least to take. Errors: bad_input (the camera does not
// give that format or size; what it gives), device.
Result<std::unique_ptr<libcamera::CameraConfiguration>> choose_configuration(libcamera::Camera& camera,
                                                                             const CameraRequest& request);

// Ours for libcamera's (DRM's) pixel format; empty: we do not read it.
std::optional<FourCc> four_cc_of(const libcamera::PixelFormat& format);

// The controls to start with. What the camera lacks is told in `notes`.
libcamera::ControlList controls_for(const libcamera::Camera& camera, const CameraRequest& request,
                                    std::vector<std::string>& notes);

// Once the picture has settled: white balance stays as the metadata of that frame say it is. Empty: nothing to lock.
libcamera::ControlList white_balance_lock(const libcamera::Camera& camera, const libcamera::ControlList& metadata);

}  // namespace kasumi
