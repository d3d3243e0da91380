// Lets the GPU read the camera's picture from the camera driver's memory without a copy. Each buffer is imported once.
#pragma once

#include <map>
#include <memory>

#include "gles/gl/objects.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/image_device.hpp"

namespace kasumi {

class PlaneImport {
 public:
  explicit PlaneImport(std::unique_ptr<ImageDevice> device) : device_(std::move(device)) {}

  // Imports plane by plane as plain textures, with results identical to uploaded ones; else as one external texture,
  // with the accuracy of the GPU driver's conversion. The memory must keep the picture until the frame drawn from it
  // has been shown. Errors: unsupported (this driver or memory: upload instead), bad_input (planes beyond the buffer,
  // impossible sizes).
  Result<CameraTextures> import(const ExternalPicture& picture, const GlInfo& info);
  // Gives all of the camera's memory back; imported textures are gone.
  void drop() { imported_.clear(); }

 private:
  class Image {  // owns an EGLImage
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

  std::unique_ptr<ImageDevice> device_;  // must outlive the images
  std::map<std::uint64_t, Imported> imported_;
  std::uint64_t imports_ = 0;
};

}  // namespace kasumi
