// The camera's picture read by the GPU where the camera's driver put it: no copy. Each buffer is imported once.
#pragma once

#include <map>
#include <memory>

#include "gles/gl/objects.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/image_device.hpp"

namespace kasumi {

class CameraImport {
 public:
  explicit CameraImport(std::unique_ptr<ImageDevice> device) : device_(std::move(device)) {}

  // Plane by plane as plain textures, which are converted as uploaded ones are, to the bit; else as one external
  // texture, within what the GPU's driver converts exactly. The memory must keep the picture until what is drawn of it
  // has been seen. Errors: unsupported (this driver, or this memory: upload instead), bad_input (planes that reach
  // beyond the buffer, impossible sizes).
  Result<CameraTextures> import(const ExternalPicture& picture, const GlInfo& info);

 private:
  class Image {  // an EGLImage and its owner
   public:
    Image(ImageDevice& device, void* image) : device_(&device), image_(image) {}
    Image(Image&& other) noexcept : device_(other.device_), image_(std::exchange(other.image_, nullptr)) {}
    Image& operator=(Image&&) = delete;
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;
    ~Image() {
      if (image_ != nullptr) device_->destroy(image_);
    }
    void* get() const { return image_; }

   private:
    ImageDevice* device_;
    void* image_;
  };
  struct Plane {
    GlTexture texture;
    Image image;
  };
  struct Imported {
    ExternalPicture picture;
    CameraTextures::Source source = CameraTextures::Source::imported;
    std::vector<Plane> planes;
    std::uint64_t used = 0;
  };

  Result<Imported> import_as(CameraTextures::Source source, const ExternalPicture& picture);

  std::unique_ptr<ImageDevice> device_;  // outlives the images
  std::map<std::uint64_t, Imported> imported_;
  std::uint64_t imports_ = 0;
};

}  // namespace kasumi
