// The camera's picture, read from the driver's buffer without a copy.
#include <drm.h>
#include <drm_mode.h>
#include <linux/udmabuf.h>
#include <sys/ioctl.h>

#include <cstdlib>

#include "tests/gles/picture/all_layouts.hpp"
#include "tests/gles/picture/lent_buffers.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class CameraImports : public GlesTest {
 protected:
  void SetUp() override {
    GlesTest::SetUp();
    if (IsSkipped()) return;
    for (const char* needed : {"GL_OES_EGL_image", "GL_OES_EGL_image_external", "GL_EXT_texture_rg"})
      if (!info().has(needed)) GTEST_SKIP() << needed << " is missing, which the test's images need";
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

  ImageCalls calls_;
};

TEST_F(CameraImports, ShowTheSameBitsAsACopyInEveryLayout) {
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

TEST_F(CameraImports, ImportEachBufferOnceAndShowItsCurrentContent) {
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

TEST_F(CameraImports, ForgetTheBuffersOfADisconnectedCamera) {
  Renderer renderer = make_renderer(with_test_images());
  std::vector<std::unique_ptr<Buffer>> first, second;
  for (std::uint64_t i = 0; i < 4; ++i) {
    first.push_back(std::make_unique<Buffer>(PixelLayout::yuyv, YuvEncoding::bt601_full, 32, 16, 0, i));
    second.push_back(std::make_unique<Buffer>(PixelLayout::yuyv, YuvEncoding::bt601_full, 32, 16, 0, 10 + i));
  }
  for (const auto& buffer : first) ASSERT_OK(renderer.import_frame(buffer->picture));
  EXPECT_EQ(calls_.destroyed, 0) << "the last picture may be shown on";
  for (int frame = 0; frame < 40; ++frame)
    ASSERT_OK(renderer.import_frame(second[static_cast<std::size_t>(frame % 4)]->picture));
  EXPECT_EQ(calls_.destroyed, 4) << "dropped automatically when other buffers arrive";
  EXPECT_EQ(calls_.made.size(), 8u);
}

TEST_F(CameraImports, ReimportABufferWhoseSizeChanged) {
  Renderer renderer = make_renderer(with_test_images());
  const Buffer wide(PixelLayout::grey8, YuvEncoding::bt601_full, 32, 16, 0, 7);
  const Buffer tall(PixelLayout::grey8, YuvEncoding::bt601_full, 16, 32, 0, 7);
  ASSERT_OK(renderer.import_frame(wide.picture));
  ASSERT_OK(renderer.import_frame(tall.picture));
  EXPECT_EQ(drawn(renderer, 16, 32).elements(), to_rgb(tall.view).elements());
  EXPECT_EQ(calls_.destroyed, 1);
}

TEST_F(CameraImports, AreNotRetriedAfterARefusal) {
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
  // A picture of another layout is still attempted.
  calls_.refused.clear();
  const Buffer other(PixelLayout::nv12, YuvEncoding::bt601_full, 16, 16, 0, 2);
  ASSERT_OK(renderer.import_frame(other.picture));
}

TEST_F(CameraImports, AreNotAttemptedOnDriversThatMayCrash) {
  if (!info().software) GTEST_SKIP() << info().renderer << " is not a software renderer";
  RendererOptions options = with_test_images();
  options.import_on_software = false;
  Renderer renderer = make_renderer(options);
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, 32, 16, 0, 1);
  for (int frame = 0; frame < 3; ++frame) {
    EXPECT_THAT(renderer.import_frame(buffer.picture), FailsAs(FaultKind::unsupported, HasSubstr(info().renderer)));
  }
  EXPECT_THAT(calls_.made, IsEmpty());
  EXPECT_THAT(renderer.notes(), testing::Contains(HasSubstr("copied")).Times(1));
}

TEST_F(CameraImports, NeverReadBeyondTheBuffer) {
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

TEST_F(CameraImports, CompositeTheObjectAsACopyDoes) {
  ReferenceScene scene = box_scene();
  Renderer renderer = loaded(scene, with_test_images());
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

// A dma-buf with the buffer's bytes: system memory as a camera without its own would use (udmabuf), or the graphics
// card's own (a dumb buffer), which even a card that refuses foreign memory can import.
class KernelMemory {
 public:
  explicit KernelMemory(const Buffer& buffer) {
    const int device = open("/dev/udmabuf", O_RDWR | O_CLOEXEC);
    if (device < 0) return;
    fcntl(buffer.fd(), F_ADD_SEALS, F_SEAL_SHRINK);
    udmabuf_create create{static_cast<std::uint32_t>(buffer.fd()), UDMABUF_FLAGS_CLOEXEC, 0, buffer.bytes()};
    fd_ = ioctl(device, UDMABUF_CREATE, &create);
    close(device);
  }
  KernelMemory(const Buffer& buffer, const char* card) : card_(open(card, O_RDWR | O_CLOEXEC)) {
    if (card_ < 0) return;
    drm_mode_create_dumb create{};
    create.width = 256;  // 32 bits a pixel, which every card supports: rows of 1024 bytes
    create.height = static_cast<std::uint32_t>(buffer.bytes() / 1024);
    create.bpp = 32;
    if (ioctl(card_, DRM_IOCTL_MODE_CREATE_DUMB, &create) != 0) return;
    drm_mode_map_dumb map{};
    map.handle = create.handle;
    drm_prime_handle prime{create.handle, DRM_CLOEXEC | DRM_RDWR, -1};
    if (ioctl(card_, DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) return;
    void* memory =
        mmap(nullptr, create.size, PROT_READ | PROT_WRITE, MAP_SHARED, card_, static_cast<off_t>(map.offset));
    if (memory == MAP_FAILED || create.size < buffer.bytes() || create.pitch != 1024) return;
    std::copy_n(buffer.memory(), buffer.bytes(), static_cast<std::uint8_t*>(memory));
    munmap(memory, create.size);
    if (ioctl(card_, DRM_IOCTL_PRIME_HANDLE_TO_FD, &prime) == 0) fd_ = prime.fd;
  }
  KernelMemory(const KernelMemory&) = delete;
  KernelMemory& operator=(const KernelMemory&) = delete;
  ~KernelMemory() {
    if (fd_ >= 0) close(fd_);
    if (card_ >= 0) close(card_);
  }
  int fd() const { return fd_; }

 private:
  int card_ = -1;
  int fd_ = -1;
};

// In the virtual machine: KASUMI_TEST_IMPORT=1 test_gles --gtest_filter=*RealDriver*
TEST_F(CameraImports, ReadARealDriversBuffer) {
  if (const auto device = egl_image_device(info()); !device)
    GTEST_SKIP() << info().renderer << " imports nothing: " << device.error().message;
  if (info().software && std::getenv("KASUMI_TEST_IMPORT") == nullptr)
    GTEST_SKIP() << info().renderer << " may crash on an import: set KASUMI_TEST_IMPORT=1 to try";
  RendererOptions options;
  options.import_on_software = true;
  int imported = 0;
  for (const char* card : {"", "/dev/dri/card0"})
    for (const PixelLayout layout : kLayouts) {
      Renderer renderer = make_renderer(options);
      const Buffer buffer(layout, YuvEncoding::bt709_limited, 256, 64, 0, 1);
      const std::unique_ptr<KernelMemory> memory =
          *card == 0 ? std::make_unique<KernelMemory>(buffer) : std::make_unique<KernelMemory>(buffer, card);
      const std::string name = fmt::format("{} in {}", name_of(layout), *card == 0 ? "udmabuf" : card);
      if (memory->fd() < 0) {
        fmt::print("{}: no such memory here\n", name);
        continue;
      }
      ExternalPicture picture = buffer.picture;
      picture.fd = memory->fd();
      if (const auto done = renderer.import_frame(picture); !done) {
        ASSERT_EQ(done.error().kind, FaultKind::unsupported) << done.error().message;
        fmt::print("{}: {}\n", name, done.error().message);
        continue;
      }
      ++imported;
      const auto shown = drawn(renderer, 256, 64);
      const auto expected = to_rgb(buffer.view);
      double sum = 0.0;
      for (std::size_t at = 0; at < shown.elements().size(); ++at)
        for (int c = 0; c < 3; ++c) sum += std::abs(shown.elements()[at][c] - expected.elements()[at][c]);
      fmt::print("{}: imported\n", name);
      EXPECT_LE(sum / (3.0 * 256 * 64), 1.0) << name << ", steps of 255 on average";
    }
  if (imported == 0) GTEST_SKIP() << info().renderer << " refused all of this machine's memory";
}

}  // namespace
}  // namespace kasumi
