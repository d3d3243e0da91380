// The building as a display lays it over the camera's picture by itself: some buffers in turn, each with noise of its
// own, so that the camera's noise is on the building too without drawing anything. One is drawn again when its turn
// comes and the building has changed.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "gles/display/display.hpp"
#include "pipeline/show/scene/compositor.hpp"

namespace kasumi {

// Belongs to the thread of its GL context, and must be gone before the display is.
class BuildingPlanes {
 public:
  // The building over the picture that the compositor took last; none where it is not to be seen. The display must have
  // shown the one before last. Errors: unsupported (no such buffers), device.
  Result<PlaneStack> next(Compositor& compositor, Display& display, Instant now);

 private:
  struct Buffer {
    std::shared_ptr<PlaneBuffer> buffer;
    std::optional<BuildingLook> look;  // that it was drawn with; empty: not yet
    Instant drawn{};
  };
  std::vector<Buffer> buffers_;
  std::size_t at_ = 0;  // given last
  int width_ = 0, height_ = 0;
};

}  // namespace kasumi
