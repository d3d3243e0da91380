// A picture from the scene camera on its way to the screen.
#pragma once

#include <cstdint>
#include <memory>

#include "capture/frame.hpp"

namespace kasumi {

struct SceneFrame {
  FrameMetadata metadata;
  DecodedPicture picture;
  std::shared_ptr<const void> holder;  // keeps the driver's buffer in use
  std::uint64_t outages = 0;           // of the camera before this frame
};

}  // namespace kasumi
