// A picture of the scene camera on its way to the screen.
#pragma once

#include <cstdint>
#include <memory>

#include "capture/frame.hpp"

namespace kasumi {

struct SceneFrame {
  FrameMetadata metadata;
  DecodedPicture picture;
  std::shared_ptr<const void> holder;  // of the driver's buffer
  std::uint64_t outages = 0;           // of the camera, before it came
};

}  // namespace kasumi
