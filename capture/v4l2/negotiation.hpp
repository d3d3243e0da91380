// Agreeing with a V4L2 driver on format, size and rate.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/camera_source.hpp"
#include "capture/v4l2/offer.hpp"

namespace kasumi {

// How a picture lies in a buffer, as agreed, and found possible.
struct V4l2Layout {
  struct MemoryPlane {
    std::uint32_t stride = 0;  // 0 for compressed formats
    std::uint32_t size = 0;    // bytes the driver needs
  };
  std::uint32_t buffer_type = 0;
  std::vector<MemoryPlane> planes;  // one: the picture's planes follow each other in it; else one for each
  // Buffers are never ours alone: who feeds v4l2loopback writes on into them, and it may hand one out twice.
  bool shared = false;
  bool multiplanar() const;
};

struct V4l2Agreement {
  CameraMode mode;
  V4l2Layout layout;
};

// Sets format, size and rate. Among several formats: colour before none, then the rate nearest to what is asked for,
// then what costs least. Errors: bad_input (format or size cannot be had; lists what can), device, disconnected.
Result<V4l2Agreement> negotiate_v4l2(VideoDevice& device, const V4l2Identity& identity, const CameraRequest& request);

}  // namespace kasumi
