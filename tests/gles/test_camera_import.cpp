// The camera's picture read where its driver put it. Without a driver that shares memory, a device of the tests stands
// in behind the boundary: its images are real EGLImages, of textures that it fills from the buffer as a GPU would read
// it.
#include <fcntl.h>
#include <linux/udmabuf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <random>
#include <set>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "gles/gl.hpp"
#include "gles/image_device.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::array kLayouts{PixelLayout::rgb8,  PixelLayout::bgr8, PixelLayout::rgba8, PixelLayout::bgra8,
                              PixelLayout::grey8, PixelLayout::yuyv, PixelLayout::uyvy,  PixelLayout::nv12,
                              PixelLayout::i420,  PixelLayout::i422, PixelLayout::i444};

std::string text_of(std::uint32_t format) {
  std::string text;
  for (unsigned shift = 0; shift < 32; shift += 8) text += static_cast<char>((format >> shift) & 0xFFu);
  return text;
}

// A picture of noise in memory that has a descriptor.
class Buffer {
 public:
  Buffer(PixelLayout layout, YuvEncoding encoding, int width, int height, std::uint32_t gap, std::uint64_t number,
         std::uint32_t first = 0) {
    static std::mt19937_64 random(3);
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
  std::size_t bytes() const { return bytes_; }

  ExternalPicture picture;
  PictureView view;  // the same, for the processor

 private:
  int fd_ = -1;
  std::size_t bytes_ = 0;
  std::uint8_t* memory_ = nullptr;
};

struct Calls {  // what was asked of the device, kept beyond its life
  std::vector<ImageRequest> made;
  int destroyed = 0;
  std::set<std::string> refused;  // formats; "*": all
};

class TestImages final : public ImageDevice {
 public:
  explicit TestImages(Calls& calls) : calls_(calls) {
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
    read(memories_.at(image));  // memory that both share needs no reading: it is just there
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
    } else {  // a driver that converts
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

  Calls& calls_;
  std::map<void*, Memory> memories_;
  PFNEGLCREATEIMAGEKHRPROC create_;
  PFNEGLDESTROYIMAGEKHRPROC destroy_;
  PFNGLEGLIMAGETARGETTEXTURE2DOESPROC show_;
};

class CameraImports : public GlesTest {
 protected:
  void SetUp() override {
    GlesTest::SetUp();
    if (IsSkipped()) return;
    for (const char* needed : {"GL_OES_EGL_image", "GL_OES_EGL_image_external", "GL_EXT_texture_rg"})
      if (!info().has(needed)) GTEST_SKIP() << needed << " is missing, of which the test's images are made";
  }
  RendererOptions with_test_images() {
    RendererOptions options;
    options.import_on_software = true;
    options.image_device = [this](const GlInfo&) -> Result<std::unique_ptr<ImageDevice>> {
      return std::make_unique<TestImages>(calls_);
    };
    return options;
  }
  Image<Rgb8> drawn(Renderer& renderer, int width, int height) {
    Offscreen target = make_target(width, height);
    const auto done = renderer.draw_background(target.target());
    EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().message);
    auto picture = target.read();
    EXPECT_TRUE(picture.has_value());
    return picture ? *picture : Image<Rgb8>();
  }

  Calls calls_;
};

TEST_F(CameraImports, ShowTheSameBitsAsACopyDoesInEveryLayout) {
  Renderer renderer = make_renderer(with_test_images());
  std::uint64_t number = 0;
  for (const PixelLayout layout : kLayouts)
    for (const auto& [width, height] : {std::pair{64, 48}, {63, 47}, {1, 1}})
      for (const auto& [gap, first] : {std::pair{0u, 0u}, {12u, 4096u}}) {
        const Buffer buffer(layout, YuvEncoding::bt709_limited, width, height, gap, ++number, first);
        ASSERT_OK(renderer.import_frame(buffer.picture));
        const auto imported = drawn(renderer, width, height), imported_large = drawn(renderer, 100, 75);
        ASSERT_OK(renderer.upload(buffer.view));
        EXPECT_EQ(imported.elements(), drawn(renderer, width, height).elements())
            << name_of(layout) << " " << width << " x " << height << ", rows " << gap << " bytes longer";
        EXPECT_EQ(imported_large.elements(), drawn(renderer, 100, 75).elements()) << name_of(layout);
      }
  for (const ImageRequest& request : calls_.made)
    EXPECT_THAT((std::set<std::string>{"R8  ", "GR88", "AB24", "BG24"}),
                testing::Contains(text_of(request.drm_format)));
}

TEST_F(CameraImports, LeaveTheConversionToTheDriverWherePlanesAreRefused) {
  Renderer renderer = make_renderer(with_test_images());
  calls_.refused = {"R8  ", "GR88", "AB24", "BG24"};
  std::uint64_t number = 0;
  for (const PixelLayout layout :
       {PixelLayout::bgr8, PixelLayout::rgba8, PixelLayout::bgra8, PixelLayout::yuyv, PixelLayout::uyvy,
        PixelLayout::nv12, PixelLayout::i420, PixelLayout::i422, PixelLayout::i444}) {
    const Buffer buffer(layout, YuvEncoding::bt709_limited, 62, 46, 4, ++number);
    ASSERT_OK(renderer.import_frame(buffer.picture));
    EXPECT_EQ(drawn(renderer, 62, 46).elements(), to_rgb(buffer.view).elements()) << name_of(layout);
    const bool yuv = plane_count(layout) > 1 || layout == PixelLayout::yuyv || layout == PixelLayout::uyvy;
    EXPECT_EQ(calls_.made.back().encoding.has_value(), yuv);
    EXPECT_EQ(calls_.made.back().planes.size(), static_cast<std::size_t>(plane_count(layout)));
  }
  EXPECT_THAT(renderer.notes(), Not(testing::Contains(HasSubstr("copied"))));
}

TEST_F(CameraImports, TakeEachBufferOnceAndShowWhatIsInItNow) {
  {
    Renderer renderer = make_renderer(with_test_images());
    std::vector<std::unique_ptr<Buffer>> buffers;
    for (std::uint64_t i = 0; i < 6; ++i)
      buffers.push_back(std::make_unique<Buffer>(PixelLayout::nv12, YuvEncoding::bt601_full, 32, 16, 0, i));
    for (int frame = 0; frame < 120; ++frame) {
      Buffer& buffer = *buffers[static_cast<std::size_t>(frame % 6)];
      buffer.fill(static_cast<std::uint8_t>(frame));
      ExternalPicture again = buffer.picture;
      again.fd = dup(buffer.fd());  // another number for the same memory
      ASSERT_OK(renderer.import_frame(again));
      close(again.fd);
      const glm::ivec3 off(glm::ivec3(drawn(renderer, 32, 16).at(5, 5)) - glm::ivec3(rgb_at(buffer.view, 5, 5)));
      ASSERT_LE(std::max({std::abs(off.r), std::abs(off.g), std::abs(off.b)}), 1) << "frame " << frame;
    }
    EXPECT_EQ(calls_.made.size(), 12u) << "six buffers of two planes";
    EXPECT_EQ(calls_.destroyed, 0);
    EXPECT_EQ(renderer.frames().imported, 120u);
    EXPECT_EQ(renderer.frames().uploaded, 0u) << "copies";
  }
  EXPECT_EQ(calls_.destroyed, 12);
}

TEST_F(CameraImports, GiveBackTheBuffersOfACameraThatIsGone) {
  Renderer renderer = make_renderer(with_test_images());
  std::vector<std::unique_ptr<Buffer>> first, second;
  for (std::uint64_t i = 0; i < 4; ++i) {
    first.push_back(std::make_unique<Buffer>(PixelLayout::yuyv, YuvEncoding::bt601_full, 32, 16, 0, i));
    second.push_back(std::make_unique<Buffer>(PixelLayout::yuyv, YuvEncoding::bt601_full, 32, 16, 0, 10 + i));
  }
  for (const auto& buffer : first) ASSERT_OK(renderer.import_frame(buffer->picture));
  const auto before = drawn(renderer, 32, 16);
  renderer.drop_camera_buffers();
  EXPECT_EQ(calls_.destroyed, 3);
  EXPECT_EQ(drawn(renderer, 32, 16).elements(), before.elements()) << "the last picture may be shown on";
  for (int frame = 0; frame < 40; ++frame)
    ASSERT_OK(renderer.import_frame(second[static_cast<std::size_t>(frame % 4)]->picture));
  EXPECT_EQ(calls_.destroyed, 4) << "forgotten by themselves when others come";
  EXPECT_EQ(calls_.made.size(), 8u);
}

TEST_F(CameraImports, TakeABufferAnewWhenAnotherPictureLiesInIt) {
  Renderer renderer = make_renderer(with_test_images());
  const Buffer wide(PixelLayout::grey8, YuvEncoding::bt601_full, 32, 16, 0, 7);
  const Buffer tall(PixelLayout::grey8, YuvEncoding::bt601_full, 16, 32, 0, 7);
  ASSERT_OK(renderer.import_frame(wide.picture));
  ASSERT_OK(renderer.import_frame(tall.picture));
  EXPECT_EQ(drawn(renderer, 16, 32).elements(), to_rgb(tall.view).elements());
  EXPECT_EQ(calls_.destroyed, 1);
}

TEST_F(CameraImports, AreNotTriedAgainWhereTheyWereRefused) {
  Renderer renderer = make_renderer(with_test_images());
  calls_.refused = {"*"};
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, 32, 16, 0, 1);
  for (int frame = 0; frame < 10; ++frame) {
    const auto refused = renderer.import_frame(buffer.picture);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::unsupported);
    ASSERT_OK(renderer.upload(buffer.view));
  }
  EXPECT_THAT(calls_.made, IsEmpty());
  EXPECT_THAT(renderer.notes(), testing::Contains(HasSubstr("copied")).Times(1));
  EXPECT_EQ(renderer.frames().uploaded, 10u);
  EXPECT_EQ(renderer.frames().imported, 0u);
  // Another kind of picture has its own chance.
  calls_.refused.clear();
  const Buffer other(PixelLayout::nv12, YuvEncoding::bt601_full, 16, 16, 0, 2);
  ASSERT_OK(renderer.import_frame(other.picture));
}

TEST_F(CameraImports, AreNotAskedOfSoftwareThatMayCrashOnThem) {
  if (!info().software) GTEST_SKIP() << info().renderer << " is no software";
  RendererOptions options = with_test_images();
  options.import_on_software = false;
  Renderer renderer = make_renderer(options);
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, 32, 16, 0, 1);
  for (int frame = 0; frame < 3; ++frame) {
    const auto refused = renderer.import_frame(buffer.picture);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::unsupported);
    EXPECT_THAT(refused.error().message, HasSubstr(info().renderer));
  }
  EXPECT_THAT(calls_.made, IsEmpty());
  EXPECT_THAT(renderer.notes(), testing::Contains(HasSubstr("copied")).Times(1));
}

TEST_F(CameraImports, NeverReachBeyondTheBuffer) {
  Renderer renderer = make_renderer(with_test_images());
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, 64, 64, 0, 1);  // 6144 bytes on two pages
  const auto expect_refused = [&](auto change) {
    ExternalPicture wrong = buffer.picture;
    change(wrong);
    const auto refused = renderer.import_frame(wrong);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input) << refused.error().message;
  };
  expect_refused([](ExternalPicture& p) { p.planes[1].offset = 8192 - 2047; });
  expect_refused([](ExternalPicture& p) { p.planes[0].stride = 63; });
  expect_refused([](ExternalPicture& p) { p.planes[0].stride = 131; });
  expect_refused([](ExternalPicture& p) { p.planes[1].stride = 0xFFFFFFFF; });
  expect_refused([](ExternalPicture& p) { p.width = 0; });
  expect_refused([](ExternalPicture& p) { p.height = 1 << 20; });
  EXPECT_THAT(calls_.made, IsEmpty());
  ExternalPicture closed = buffer.picture;
  closed.fd = -1;
  EXPECT_EQ(renderer.import_frame(closed).error().kind, FaultKind::unsupported);
}

TEST_F(CameraImports, TakeTheObjectAsACopyDoes) {
  ReferenceScene scene = box_scene();
  Renderer renderer = make_renderer(with_test_images());
  load(renderer, scene);
  std::uint64_t number = 0;
  for (const bool by_driver : {false, true}) {
    if (by_driver) calls_.refused = {"R8  ", "GR88", "AB24"};
    for (const PixelLayout layout : {PixelLayout::nv12, PixelLayout::yuyv, PixelLayout::bgra8}) {
      const Buffer buffer(layout, YuvEncoding::bt709_full, 160, 120, 8, ++number);
      const auto both = [&] {
        std::vector<Image<Rgb8>> pictures;
        for (const bool moving : {false, true}) {
          Offscreen target = make_target(160, 120);
          const auto done = moving ? renderer.draw_moving(scene.appearance, scene.measured, target.target())
                                   : renderer.draw(scene.measured, target.target());
          EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().message);
          pictures.push_back(*target.read());
        }
        return pictures;
      };
      ASSERT_OK(renderer.import_frame(buffer.picture));
      const auto imported = both();
      ASSERT_OK(renderer.upload(buffer.view));
      const auto copied = both();
      for (std::size_t i = 0; i < 2; ++i) {
        int worst = 0;
        for (std::size_t at = 0; at < imported[i].elements().size(); ++at)
          for (int c = 0; c < 3; ++c)
            worst = std::max(worst, std::abs(imported[i].elements()[at][c] - copied[i].elements()[at][c]));
        EXPECT_LE(worst, by_driver ? 1 : 0) << name_of(layout) << (by_driver ? ", converted by the driver" : "");
      }
    }
  }
}

// Memory of the kernel's, imported by the real driver.
class SharedMemory {
 public:
  explicit SharedMemory(const Buffer& buffer) {
    const int device = open("/dev/udmabuf", O_RDWR | O_CLOEXEC);
    if (device < 0) return;
    fcntl(buffer.fd(), F_ADD_SEALS, F_SEAL_SHRINK);
    udmabuf_create create{static_cast<std::uint32_t>(buffer.fd()), UDMABUF_FLAGS_CLOEXEC, 0, buffer.bytes()};
    fd_ = ioctl(device, UDMABUF_CREATE, &create);
    close(device);
  }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory() {
    if (fd_ >= 0) close(fd_);
  }
  int fd() const { return fd_; }

 private:
  int fd_ = -1;
};

TEST_F(CameraImports, ReadARealDriversBuffer) {
  if (const auto device = egl_image_device(info()); !device)
    GTEST_SKIP() << info().renderer << " imports nothing: " << device.error().message;
  if (info().software && std::getenv("KASUMI_TEST_IMPORT") == nullptr)
    GTEST_SKIP() << info().renderer << " may crash on an import: set KASUMI_TEST_IMPORT=1 to try";
  RendererOptions options;
  options.import_on_software = true;
  int imported = 0;
  std::string refusals;
  for (const PixelLayout layout : kLayouts) {
    Renderer renderer = make_renderer(options);
    const Buffer buffer(layout, YuvEncoding::bt709_limited, 256, 64, 0, 1);
    const SharedMemory memory(buffer);
    if (memory.fd() < 0) GTEST_SKIP() << "no /dev/udmabuf to make a buffer of";
    ExternalPicture picture = buffer.picture;
    picture.fd = memory.fd();
    if (const auto done = renderer.import_frame(picture); !done) {
      ASSERT_EQ(done.error().kind, FaultKind::unsupported) << done.error().message;
      refusals += fmt::format("{}: {}\n", name_of(layout), done.error().message);
      continue;
    }
    ++imported;
    const auto shown = drawn(renderer, 256, 64);
    const auto expected = to_rgb(buffer.view);
    double sum = 0.0;
    for (std::size_t at = 0; at < shown.elements().size(); ++at)
      for (int c = 0; c < 3; ++c) sum += std::abs(shown.elements()[at][c] - expected.elements()[at][c]);
    EXPECT_LE(sum / (3.0 * 256 * 64), 1.0) << name_of(layout) << ", steps of 255 on average";
  }
  fmt::print("{} of {} layouts imported by {}\n{}", imported, kLayouts.size(), info().renderer, refusals);
  if (imported == 0) GTEST_SKIP() << "the driver refused this memory in every layout: pictures are copied";
}

}  // namespace
}  // namespace kasumi
