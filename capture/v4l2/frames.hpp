// From a buffer the driver filled to a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/v4l2/buffers.hpp"

namespace kasumi {

// What is known of the frame. `captured_at` is the driver's time when it is monotonic, else now.
FrameMetadata v4l2_metadata(const V4l2Filled& filled, const CameraMode& mode, const V4l2Layout& layout,
                            const Clock& clock);

// The frame's bytes copied out. Planes in memories of their own are gathered to follow each other, each row with the
// stride stride_of_plane() has.
std::vector<std::uint8_t> v4l2_bytes(const V4l2Filled& filled, const FrameMetadata& metadata, const V4l2Layout& layout);

}  // namespace kasumi
