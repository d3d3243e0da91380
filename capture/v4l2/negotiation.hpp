// Negotiates format, size and rate with a V4L2 driver.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/camera_source.hpp"
#include "capture/v4l2/offer.hpp"

namespace kasumi {

// The negotiated and validated layout of a picture in a buffer.
struct V4l2Layout {
  struct MemoryPlane {
    std::uint32_t stride = 0;  // 0 for compressed formats
    std::uint32_t size = 0;    // bytes the driver needs
  };
  std::uint32_t buffer_type = 0;
  std::vector<MemoryPlane> planes;  // one holding all of the picture's planes, or one for each
  // Buffers are shared with the writer: a v4l2loopback feeder keeps writing into them, and one may be dequeued twice.
  bool shared = false;
  bool multiplanar() const;
};

struct V4l2Agreement {
  CameraMode mode;
  V4l2Layout layout;
};

// Sets format, size and rate. Among several formats: colour before grey, then the nearest rate, then the lowest
// processing cost. Errors: bad_input (format or size not offered; lists the offer), device, disconnected.
Result<V4l2Agreement> negotiate_v4l2(VideoDevice& device, const V4l2Identity& identity, const CameraRequest& request);

}  // namespace kasumi
