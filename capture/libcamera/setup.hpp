// Configures a libcamera camera: its stream's format and size, and its controls.
#pragma once

#include <memory>

#include <libcamera/libcamera.h>

#include "capture/camera_source.hpp"

namespace kasumi {

// The validated stream configuration, in the format that is cheapest to process. Errors: bad_input (the camera does not
// offer that format or size; lists what it offers), device.
Result<std::unique_ptr<libcamera::CameraConfiguration>> choose_configuration(libcamera::Camera& camera,
                                                                             const CameraRequest& request);

// Kasumi's code for libcamera's (DRM's) pixel format; empty: Kasumi does not read it.
std::optional<FourCc> four_cc_of(const libcamera::PixelFormat& format);

// The initial controls. Controls the camera lacks are reported in `notes`.
libcamera::ControlList controls_for(const libcamera::Camera& camera, const CameraRequest& request,
                                    std::vector<std::string>& notes);

// Locks white balance at the values in this frame's metadata, once it has settled. Empty: nothing to lock.
libcamera::ControlList white_balance_lock(const libcamera::Camera& camera, const libcamera::ControlList& metadata);

}  // namespace kasumi
