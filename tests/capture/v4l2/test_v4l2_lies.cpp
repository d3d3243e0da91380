// A driver whose answers are damaged at random: nothing outside its memory is read, nothing hangs, nothing leaks. Most
// meaningful under the address and undefined sanitizers.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/capture/known_frames.hpp"
#include "tests/capture/v4l2/fake_camera.hpp"

namespace kasumi {
namespace {

class Liar {
 public:
  explicit Liar(std::uint64_t seed) : random_(seed) {}

  void operator()(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP: return damage<v4l2_capability>(argument);
      case VIDIOC_ENUM_FMT: return damage<v4l2_fmtdesc>(argument);
      case VIDIOC_ENUM_FRAMESIZES: return damage<v4l2_frmsizeenum>(argument);
      case VIDIOC_ENUM_FRAMEINTERVALS: return damage<v4l2_frmivalenum>(argument);
      case VIDIOC_S_FMT: return damage<v4l2_format>(argument);
      case VIDIOC_S_PARM: return damage<v4l2_streamparm>(argument);
      case VIDIOC_REQBUFS: return damage<v4l2_requestbuffers>(argument);
      case VIDIOC_QUERYCTRL: return damage<v4l2_queryctrl>(argument);
      case VIDIOC_G_CTRL: return damage<v4l2_control>(argument);
      case VIDIOC_DQEVENT: return damage<v4l2_event>(argument);
      case VIDIOC_QUERYBUF:
      case VIDIOC_DQBUF: {
        // The pointer to the planes is ours; what it points to is the driver's.
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        const auto m = buffer.m;
        const bool multiplanar = V4L2_TYPE_IS_MULTIPLANAR(buffer.type);
        if (multiplanar && one_in(3)) damage<v4l2_plane>(buffer.m.planes);
        damage<v4l2_buffer>(argument);
        if (multiplanar) buffer.m = m;
        return;
      }
      default: return;
    }
  }
  bool one_in(std::uint64_t n) { return random_() % n == 0; }

 private:
  template <class T>
  void damage(void* argument) {
    if (!one_in(25)) return;
    auto* bytes = static_cast<std::uint8_t*>(argument);
    const auto at = random_() % (sizeof(T) / 4) * 4;  // all of them consist of 32-bit words
    const std::array<std::uint32_t, 8> values{0,          1,          2,    0x7fffffff,
                                              0x80000000, 0xffffffff, 4096, static_cast<std::uint32_t>(random_())};
    const auto value = values[random_() % values.size()];
    std::memcpy(bytes + at, &value, 4);
  }

  std::mt19937_64 random_;
};

TEST(V4l2Lies, NoFalseAnswerCausesHarm) {
  int opened = 0, frames = 0, faults = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    FastForwardClock clock{Utc{}};
    const bool multiplanar = seed % 2 == 1;
    const std::uint32_t code = multiplanar ? (seed % 4 == 1 ? V4L2_PIX_FMT_NV12M : V4L2_PIX_FMT_YUV420M)
                                           : (seed % 4 == 0 ? V4L2_PIX_FMT_YUYV : V4L2_PIX_FMT_MJPEG);
    FakeCamera camera({{code, 32, 24}, {V4L2_PIX_FMT_NV12, 16, 16}}, clock);
    camera.multiplanar = multiplanar;
    camera.controls = {{V4L2_CID_GAIN, {0, 255, 1, 64}}, {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1, 1}}};
    const auto liar = std::make_shared<Liar>(seed);
    camera.lie([liar](unsigned long request, void* argument) { (*liar)(request, argument); });
    {
      V4l2Options options{"/dev/v4l/by-id/fake", {.width = 32, .height = 24, .gain = 3.0}};
      auto source = open_v4l2_source(camera.open(), options, clock);
      faults += !source;
      opened += source.has_value();
      std::vector<Frame> held;
      for (int i = 0; source && i < 60; ++i) {
        auto frame = (*source)->next(clock.now() + 100ms);
        if (!frame) {
          faults += frame.error().kind != FaultKind::timeout;
          continue;
        }
        ++frames;
        std::uint32_t sum = 0;
        for (const auto byte : frame->payload.bytes) sum += byte;
        EXPECT_LE(sum, 0xffu * frame->payload.bytes.size());
        if (frame->metadata.status == FrameStatus::good) (void)decode(*frame, YuvEncoding::bt601_full);
        if (liar->one_in(3)) held.push_back(std::move(*frame));
        if (liar->one_in(5)) held.clear();
      }
    }
    EXPECT_EQ(camera.opened(), 0);
    EXPECT_EQ(camera.mapped(), 0);
  }
  // The damage is neither so weak that nothing fails, nor so strong that nothing opens.
  EXPECT_GT(opened, 300);
  EXPECT_GT(frames, 3000);
  EXPECT_GT(faults, 1000);
}

}  // namespace
}  // namespace kasumi
