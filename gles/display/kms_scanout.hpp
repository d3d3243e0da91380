// Surfaces that GL draws to and the card can scan out. Like KmsDevice, an interface that tests can replace.
#pragma once

#include <cstdint>
#include <memory>

#include "base/result.hpp"
#include "gles/display/display.hpp"
#include "gles/display/kms_device.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

// A finished picture. Its buffer is reused only after this is destroyed.
class ScanoutPicture {
 public:
  virtual ~ScanoutPicture() = default;
  virtual std::uint32_t framebuffer() const = 0;
};

class Scanout {
 public:
  virtual ~Scanout() = default;
  virtual GlContext& context() = 0;
  virtual bool has_free_buffer() const = 0;
  virtual DrawTarget target() const = 0;
  // Ends the picture drawn since the last call. GL may still be drawing it, but finishes before the card shows it. All
  // pictures must be destroyed before the scanout. Error: device.
  virtual Result<std::unique_ptr<ScanoutPicture>> finish() = 0;
  // ARGB8888, for a plane above another. Errors: unsupported, device.
  virtual Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int width, int height) = 0;
};

// Through GBM and EGL, XRGB8888. The device must outlive the scanout. Errors: unsupported, device.
Result<std::unique_ptr<Scanout>> open_gbm_scanout(KmsDevice& device, int width, int height);

}  // namespace kasumi
