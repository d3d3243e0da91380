// The EGL and GL calls that let a texture read other drivers' memory: an interface that tests can replace. For this
// room's sources and its tests.
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

// The description of an EGLImage: linear, uncompressed, top row first.
struct ImageRequest {
  std::uint32_t drm_format = 0;  // the kernel's four-character code
  int width = 0;                 // texels
  int height = 0;
  int fd = -1;
  std::vector<ExternalPlane> planes;
  std::optional<YuvEncoding> encoding{};  // for the driver's conversion
};

// plain: sampled as an ordinary texture. external: only through samplerExternalOES, which converts YUV.
enum class ImageSampling { plain, external };

class ImageDevice {
 public:
  virtual ~ImageDevice() = default;
  // Whether the driver reports that linear memory of this format can be sampled that way. Error: unsupported, with the
  // reason.
  virtual Result<> offers(std::uint32_t drm_format, ImageSampling sampling) = 0;
  // An EGLImage. Error: unsupported, with the driver's reason.
  virtual Result<void*> make(const ImageRequest& request) = 0;
  virtual void destroy(void* image) = 0;
  // Attaches the image's current contents to the texture. Error: unsupported.
  virtual Result<> show_in(unsigned texture, ImageSampling sampling, void* image) = 0;
};

// For the current context's display. Error: unsupported (extensions missing).
Result<std::unique_ptr<ImageDevice>> egl_image_device(const GlInfo& info);

}  // namespace kasumi
