// Planes as the kernel's own display without hardware (vkms) composes them: it blends as controllers do and gives the
// picture back. Skipped without it (vkms with enable_overlay=1; kernels that check clones, as Debian's 6.1, refuse its
// writeback connector unless both of its encoders name each other in possible_clones).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include <drm_fourcc.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "base/unique_fd.hpp"
#include "gles/display/display_listing.hpp"
#include "tests/gles/display/kms_decorator.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr int kWidth = 640, kHeight = 480;

// A buffer of XR24 in a card's memory.
class DumbBuffer {
 public:
  explicit DumbBuffer(int fd) : fd_(fd) {
    if (drmModeCreateDumbBuffer(fd, kWidth, kHeight, 32, 0, &handle_, &stride_, &bytes_) != 0) return;
    std::uint64_t offset = 0;
    if (drmModeMapDumbBuffer(fd, handle_, &offset) != 0) return;
    void* mapped = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
    if (mapped != MAP_FAILED) pixels_ = static_cast<std::uint8_t*>(mapped);
  }
  DumbBuffer(const DumbBuffer&) = delete;
  DumbBuffer& operator=(const DumbBuffer&) = delete;
  ~DumbBuffer() {
    if (pixels_ != nullptr) munmap(pixels_, bytes_);
    drmModeDestroyDumbBuffer(fd_, handle_);
  }
  std::uint32_t handle() const { return handle_; }
  std::uint32_t stride() const { return stride_; }
  std::uint8_t* row(int y) const { return pixels_ + static_cast<std::size_t>(y) * stride_; }
  Image<Rgb8> read() const {
    Image<Rgb8> picture(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) picture.at(x, y) = {row(y)[4 * x + 2], row(y)[4 * x + 1], row(y)[4 * x]};
    return picture;
  }
  void write(const Image<Rgb8>& picture) const {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Rgb8 pixel = picture.at(x, y);
        const std::array<std::uint8_t, 4> bytes{pixel.b, pixel.g, pixel.r, 255};
        std::memcpy(row(y) + 4 * x, bytes.data(), bytes.size());
      }
  }

 private:
  int fd_;
  std::uint32_t handle_ = 0, stride_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint8_t* pixels_ = nullptr;
};

std::uint32_t property(int fd, std::uint32_t object, std::uint32_t type, const char* name,
                       std::uint64_t* value = nullptr) {
  drmModeObjectProperties* all = drmModeObjectGetProperties(fd, object, type);
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; all != nullptr && i < all->count_props; ++i) {
    drmModePropertyRes* one = drmModeGetProperty(fd, all->props[i]);
    if (one != nullptr && std::strcmp(one->name, name) == 0) {
      found = one->prop_id;
      if (value != nullptr) *value = all->prop_values[i];
    }
    drmModeFreeProperty(one);
  }
  drmModeFreeObjectProperties(all);
  return found;
}

// The camera's buffer as another driver exports it.
struct CameraBuffer {
  explicit CameraBuffer(const std::string& card, std::uint64_t number)
      : fd(open(card.c_str(), O_RDWR | O_CLOEXEC)), memory(fd.value()) {
    int exported = -1;
    if (drmPrimeHandleToFD(fd.value(), memory.handle(), DRM_CLOEXEC | DRM_RDWR, &exported) == 0)
      dma_buf = UniqueFd(exported);
    picture = {dma_buf.value(), number, PixelLayout::bgra8, {}, kWidth, kHeight, {ExternalPlane{0, memory.stride()}}};
  }
  UniqueFd fd;
  DumbBuffer memory;
  UniqueFd dma_buf;
  ExternalPicture picture;
};

class KmsWriteback : public testing::Test {
 protected:
  void SetUp() override {
    for (const ListedCard& card : list_displays())
      if (card.driver == "vkms") card_ = card.path;
    if (card_.empty()) GTEST_SKIP() << "no vkms here";
    KmsDisplayOptions options;
    options.device = card_;
    options.width = kWidth;
    options.height = kHeight;
    auto display = open_kms_display(options, clock_, system_);
    ASSERT_OK(display);
    display_ = std::move(*display);
    auto renderer = Renderer::create(display_->context());
    ASSERT_OK(renderer);
    renderer_.emplace(std::move(*renderer));
    scene_ = box_scene();
    scene_.view = view_north(kWidth, kHeight, 8000);
    scene_.appearance = afternoon(scene_.view);
    scene_.measured = measured_airlight(scene_.view);
    ASSERT_OK(renderer_->set_model(scene_.model));
    ASSERT_OK(renderer_->set_view(scene_.view, scene_.model_to_world));
    ASSERT_OK(renderer_->set_detail({1.0, 1, 1}));
    ASSERT_OK(renderer_->redraw_layer(scene_.appearance));
  }

  Result<DrawTarget> begin() { return display_->begin(clock_.now() + 3s); }
  // What the display shows now.
  Image<Rgb8> read_back() {
    EXPECT_TRUE(begin());  // the last picture is shown
    const int fd = system_->last->fd();
    drmSetClientCap(fd, DRM_CLIENT_CAP_WRITEBACK_CONNECTORS, 1);
    drmModeRes* resources = drmModeGetResources(fd);
    std::uint32_t connector = 0;
    for (int i = 0; i < resources->count_connectors; ++i) {
      drmModeConnector* one = drmModeGetConnectorCurrent(fd, resources->connectors[i]);
      if (one->connector_type == DRM_MODE_CONNECTOR_WRITEBACK) connector = one->connector_id;
      drmModeFreeConnector(one);
    }
    const std::uint32_t crtc = resources->crtcs[0];
    drmModeFreeResources(resources);

    const DumbBuffer memory(fd);
    std::uint32_t framebuffer = 0;
    const std::array<std::uint32_t, 4> handles{memory.handle()}, strides{memory.stride()}, offsets{};
    EXPECT_EQ(drmModeAddFB2(fd, kWidth, kHeight, DRM_FORMAT_XRGB8888, handles.data(), strides.data(), offsets.data(),
                            &framebuffer, 0),
              0);
    std::int32_t fence = -1;
    drmModeAtomicReq* request = drmModeAtomicAlloc();
    const auto set = [&](const char* name, std::uint64_t value) {
      drmModeAtomicAddProperty(request, connector, property(fd, connector, DRM_MODE_OBJECT_CONNECTOR, name), value);
    };
    set("CRTC_ID", crtc);
    set("WRITEBACK_FB_ID", framebuffer);
    set("WRITEBACK_OUT_FENCE_PTR", reinterpret_cast<std::uintptr_t>(&fence));
    EXPECT_EQ(drmModeAtomicCommit(fd, request, DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr), 0) << std::strerror(errno);
    drmModeAtomicFree(request);
    const UniqueFd done(fence);
    pollfd polled{fence, POLLIN, 0};
    EXPECT_EQ(poll(&polled, 1, 10'000), 1) << "the picture is written";
    auto picture = memory.read();
    drmModeRmFB(fd, framebuffer);
    return picture;
  }
  Image<Rgb8> composed_by_the_gpu(const Image<Rgb8>& camera) {
    const auto target = begin();
    EXPECT_TRUE(target);
    EXPECT_TRUE(renderer_->upload(view_of(camera)));
    EXPECT_TRUE(renderer_->draw(scene_.measured, *target));
    EXPECT_TRUE(display_->show());
    return read_back();
  }

  SystemClock clock_;
  std::string card_;
  std::shared_ptr<DecoratedSystem> system_ = std::make_shared<DecoratedSystem>();
  std::unique_ptr<Display> display_;
  std::optional<Renderer> renderer_;
  ReferenceScene scene_;
};

TEST_F(KmsWriteback, ShowsThePictureThatTheGpuComposes) {
  const auto camera = landscape(kWidth, kHeight);
  auto moved = camera;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        moved.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(moved.at(x, y)[c] + ((x + y) % 2 ? 16 : -16), 0, 255));
  const auto by_gpu = composed_by_the_gpu(camera), by_gpu_moved = composed_by_the_gpu(moved);

  CameraBuffer first(card_, 1), second(card_, 2);
  first.memory.write(camera);
  second.memory.write(moved);
  ASSERT_TRUE(begin());
  const PixelBox all = renderer_->object_box(), seen = renderer_->drawn_box();
  auto building = display_->make_plane_buffer(all.right - all.left, all.bottom - all.top);
  ASSERT_OK(building);
  ASSERT_OK(renderer_->upload(view_of(camera)));
  ASSERT_OK(renderer_->draw_for_plane(scene_.measured, (*building)->target()));
  PlaneStack picture{first.picture, *building};
  picture.left = seen.left, picture.top = seen.top, picture.right = seen.right, picture.bottom = seen.bottom;
  picture.source_left = seen.left - all.left, picture.source_top = seen.top - all.top;
  ASSERT_OK(display_->show_planes(picture));
  const auto on_planes = difference(read_back(), by_gpu);
  picture.camera = second.picture;
  ASSERT_OK(display_->show_planes(picture));
  const auto on_planes_moved = difference(read_back(), by_gpu_moved);
  fmt::print(
      "planes against the GPU's composite: {:.1f} dB, {} steps at worst, {} pixels differ; over a background "
      "that moved by 16: {:.1f} dB, {} steps\n",
      on_planes.psnr_db, on_planes.largest, on_planes.changed, on_planes_moved.psnr_db, on_planes_moved.largest);
  EXPECT_LE(on_planes.largest, 1);
  EXPECT_GE(on_planes.psnr_db, 45.0);
  EXPECT_LE(on_planes_moved.largest, 4);
  EXPECT_GE(on_planes_moved.psnr_db, 45.0);
  EXPECT_LT(on_planes.changed, (all.right - all.left) * (all.bottom - all.top) / 4) << "opaque pixels are the same";

  // And back, in one commit.
  EXPECT_EQ(difference(composed_by_the_gpu(camera), by_gpu).changed, 0);
}

}  // namespace
}  // namespace kasumi
