// A camera's buffers and a GPU that reads them, for machines whose drivers share no memory: the images are real
// EGLImages of textures that the test's device fills from the buffer as a GPU would read it.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <gtest/gtest.h>

#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"
#include "gles/picture/external_picture.hpp"
#include "gles/picture/image_device.hpp"

namespace kasumi {

inline std::string text_of(std::uint32_t format) {
  std::string text;
  for (unsigned shift = 0; shift < 32; shift += 8) text += static_cast<char>((format >> shift) & 0xFFu);
  return text;
}

// A picture of noise in memory with a file descriptor: of one size, the same for each number.
class Buffer {
 public:
  Buffer(PixelLayout layout, YuvEncoding encoding, int width, int height, std::uint32_t gap, std::uint64_t number,
         std::uint32_t first = 0) {
    std::mt19937_64 random(2 + number);
    picture = {-1, number, layout, encoding, width, height, {}};
    view = {layout, encoding, width, height, {}};
    std::uint32_t end = first;
    for (int i = 0; i < plane_count(layout); ++i) {
      const PlaneSize size = plane_size(layout, width, height, i);
      const auto stride = static_cast<std::uint32_t>(size.row_bytes) + gap;
      picture.planes[static_cast<std::size_t>(i)] = {end, stride};
      end += stride * static_cast<std::uint32_t>(size.rows);
    }
    const long page = sysconf(_SC_PAGESIZE);
    bytes_ =
        (end + static_cast<std::size_t>(page) - 1) / static_cast<std::size_t>(page) * static_cast<std::size_t>(page);
    fd_ = memfd_create("camera", MFD_ALLOW_SEALING | MFD_CLOEXEC);
    EXPECT_EQ(ftruncate(fd_, static_cast<off_t>(bytes_)), 0);
    memory_ = static_cast<std::uint8_t*>(mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0));
    for (std::size_t i = 0; i < bytes_; ++i) memory_[i] = static_cast<std::uint8_t>(random() >> 56);
    for (std::size_t i = 0; i < 3; ++i)
      if (static_cast<int>(i) < plane_count(layout))
        view.planes[i] = {memory_ + picture.planes[i].offset, picture.planes[i].stride};
    picture.fd = fd_;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() {
    munmap(memory_, bytes_);
    close(fd_);
  }
  void fill(std::uint8_t value) { std::fill_n(memory_, bytes_, value); }
  int fd() const { return fd_; }
  const std::uint8_t* memory() const { return memory_; }
  std::size_t bytes() const { return bytes_; }

  ExternalPicture picture;
  PictureView view;  // the same, for the processor

 private:
  int fd_ = -1;
  std::size_t bytes_ = 0;
  std::uint8_t* memory_ = nullptr;
};

struct ImageCalls {  // calls made to the device; outlives it
  std::vector<ImageRequest> made;
  int destroyed = 0;
  std::set<std::string> refused;  // formats; "*": all
};

class TestImages final : public ImageDevice {
 public:
  explicit TestImages(ImageCalls& calls) : calls_(calls) {
    create_ = reinterpret_cast<PFNEGLCREATEIMAGEKHRPROC>(eglGetProcAddress("eglCreateImageKHR"));
    destroy_ = reinterpret_cast<PFNEGLDESTROYIMAGEKHRPROC>(eglGetProcAddress("eglDestroyImageKHR"));
    show_ = reinterpret_cast<PFNGLEGLIMAGETARGETTEXTURE2DOESPROC>(eglGetProcAddress("glEGLImageTargetTexture2DOES"));
  }

  Result<> offers(std::uint32_t format, ImageSampling) override {
    if (calls_.refused.contains(text_of(format)) || calls_.refused.contains("*"))
      return fail(FaultKind::unsupported, "no {} here", text_of(format));
    return {};
  }

  Result<void*> make(const ImageRequest& request) override {
    calls_.made.push_back(request);
    Memory memory{request, dup(request.fd), make_texture()};
    read(memory);
    const EGLImageKHR image =
        create_(eglGetCurrentDisplay(), eglGetCurrentContext(), EGL_GL_TEXTURE_2D_KHR,
                reinterpret_cast<EGLClientBuffer>(static_cast<std::uintptr_t>(memory.texture.name())), nullptr);
    EXPECT_NE(image, EGL_NO_IMAGE_KHR);
    memories_.emplace(image, std::move(memory));
    return image;
  }

  void destroy(void* image) override {
    ++calls_.destroyed;
    destroy_(eglGetCurrentDisplay(), image);
    const auto found = memories_.find(image);
    ASSERT_NE(found, memories_.end());
    close(found->second.fd);
    memories_.erase(found);
  }

  Result<> show_in(unsigned texture, ImageSampling sampling, void* image) override {
    read(memories_.at(image));  // shared memory needs no copy
    const GLenum target = sampling == ImageSampling::external ? GL_TEXTURE_EXTERNAL_OES : GL_TEXTURE_2D;
    glBindTexture(target, texture);
    show_(target, image);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return {};
  }

 private:
  struct Memory {
    ImageRequest request;
    int fd;
    GlTexture texture;
  };

  static void read(Memory& memory) {
    const ImageRequest& r = memory.request;
    const std::string format = text_of(r.drm_format);
    const auto size = static_cast<std::size_t>(lseek(memory.fd, 0, SEEK_END));
    const auto* bytes = static_cast<const std::uint8_t*>(mmap(nullptr, size, PROT_READ, MAP_SHARED, memory.fd, 0));
    glBindTexture(GL_TEXTURE_2D, memory.texture.name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const std::map<std::string, std::pair<GLenum, std::size_t>> plain{
        {"R8  ", {GL_RED_EXT, 1}}, {"GR88", {GL_RG_EXT, 2}}, {"BG24", {GL_RGB, 3}}, {"AB24", {GL_RGBA, 4}}};
    if (const auto known = plain.find(format); known != plain.end()) {
      const auto [gl, texel] = known->second;
      const std::size_t row = texel * static_cast<std::size_t>(r.width);
      std::vector<std::uint8_t> rows(row * static_cast<std::size_t>(r.height));
      for (std::size_t y = 0; y < static_cast<std::size_t>(r.height); ++y)
        std::copy_n(bytes + r.planes.front().offset + y * r.planes.front().stride, row, rows.data() + y * row);
      glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(gl), r.width, r.height, 0, gl, GL_UNSIGNED_BYTE, rows.data());
    } else {  // the driver converts
      const std::map<std::string, PixelLayout> layouts{
          {"NV12", PixelLayout::nv12},  {"YU12", PixelLayout::i420},  {"YU16", PixelLayout::i422},
          {"YU24", PixelLayout::i444},  {"YUYV", PixelLayout::yuyv},  {"UYVY", PixelLayout::uyvy},
          {"XB24", PixelLayout::rgba8}, {"XR24", PixelLayout::bgra8}, {"RG24", PixelLayout::bgr8}};
      PictureView view{layouts.at(format), r.encoding.value_or(YuvEncoding::bt601_full), r.width, r.height, {}};
      for (std::size_t i = 0; i < r.planes.size(); ++i)
        view.planes[i] = {bytes + r.planes[i].offset, r.planes[i].stride};
      const Image<Rgb8> rgb = to_rgb(view);
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, r.width, r.height, 0, GL_RGB, GL_UNSIGNED_BYTE, rgb.elements().data());
    }
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
    munmap(const_cast<std::uint8_t*>(bytes), size);
  }

  ImageCalls& calls_;
  std::map<void*, Memory> memories_;
  PFNEGLCREATEIMAGEKHRPROC create_;
  PFNEGLDESTROYIMAGEKHRPROC destroy_;
  PFNGLEGLIMAGETARGETTEXTURE2DOESPROC show_;
};

}  // namespace kasumi
