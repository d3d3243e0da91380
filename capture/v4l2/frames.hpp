// Turns a buffer filled by the driver into a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/v4l2/buffers.hpp"

namespace kasumi {

// The frame's metadata. `captured_at` is the driver's timestamp if it is monotonic, else now.
FrameMetadata v4l2_metadata(const V4l2Filled& filled, const CameraMode& mode, const V4l2Layout& layout,
                            const Clock& clock);

// A copy of the frame's bytes. Planes in separate memory are placed one after the other, with the row strides of
// stride_of_plane().
std::vector<std::uint8_t> v4l2_bytes(const V4l2Filled& filled, const FrameMetadata& metadata, const V4l2Layout& layout);

}  // namespace kasumi
