// The calls of EGL and GL that let a texture read memory of other drivers. A boundary that tests can stand behind.
// For this room's sources and its tests.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/picture/external_picture.hpp"

namespace kasumi {

// What one EGLImage is to be made of: rows from the first on, linear, no compression.
struct ImageRequest {
  std::uint32_t drm_format = 0;  // the kernel's four-character code
  int width = 0;                 // texels
  int height = 0;
  int fd = -1;
  std::vector<ExternalPlane> planes;
  std::optional<YuvEncoding> encoding{};  // the driver is to convert by
};

// plain: sampled as any texture. external: only through samplerExternalOES, which converts YUV by itself.
enum class ImageSampling { plain, external };

class ImageDevice {
 public:
  virtual ~ImageDevice() = default;
  // Whether linear memory of this format can be had that way, as far as the driver says. Error: unsupported, with why.
  virtual Result<> offers(std::uint32_t drm_format, ImageSampling sampling) = 0;
  // An EGLImage. Error: unsupported, with the driver's reason.
  virtual Result<void*> make(const ImageRequest& request) = 0;
  virtual void destroy(void* image) = 0;
  // Lets the texture show the image as it is now. Error: unsupported.
  virtual Result<> show_in(unsigned texture, ImageSampling sampling, void* image) = 0;
};

// Of the current context's display. Error: unsupported (extensions missing).
Result<std::unique_ptr<ImageDevice>> egl_image_device(const GlInfo& info);

}  // namespace kasumi
