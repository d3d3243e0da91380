// Which devices are listed as decoders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>

#include "capture/v4l2/decoders.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;

struct FakeFormat {
  std::uint32_t code = 0;
  bool compressed = false;
};

// A memory-to-memory device that answers what it is and what goes in and out.
class FakeCodec final : public VideoDevice {
 public:
  std::uint32_t abilities = V4L2_CAP_VIDEO_M2M_MPLANE | V4L2_CAP_STREAMING;
  std::vector<FakeFormat> in{{V4L2_PIX_FMT_H264, true}, {V4L2_PIX_FMT_MJPEG, true}}, out{{V4L2_PIX_FMT_NV12}};
  int refuses = 0;       // an errno
  bool endless = false;  // repeats its last format for ever
  std::string driver = "bcm2835-codec";

  int control(unsigned long request, void* argument) override {
    if (refuses != 0) return refuses;
    if (request == VIDIOC_QUERYCAP) {
      auto& answer = *static_cast<v4l2_capability*>(argument);
      std::memcpy(answer.driver, driver.data(), std::min(driver.size(), sizeof answer.driver));
      answer.device_caps = abilities;
      answer.capabilities = abilities | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    if (request != VIDIOC_ENUM_FMT) return ENOTTY;
    auto& entry = *static_cast<v4l2_fmtdesc*>(argument);
    const bool planar = (abilities & V4L2_CAP_VIDEO_M2M_MPLANE) != 0;
    const bool input = entry.type == (planar ? V4L2_BUF_TYPE_VIDEO_OUTPUT_MPLANE : V4L2_BUF_TYPE_VIDEO_OUTPUT);
    if (!input && entry.type != (planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE))
      return EINVAL;
    const auto& formats = input ? in : out;
    if (formats.empty() || (entry.index >= formats.size() && !endless)) return EINVAL;
    const auto& format = formats[std::min<std::size_t>(entry.index, formats.size() - 1)];
    entry.pixelformat = format.code;
    entry.flags = format.compressed ? V4L2_FMT_FLAG_COMPRESSED : 0;
    return 0;
  }
  VideoEvents wait(Duration) override { return {}; }
  std::span<const std::uint8_t> map(std::size_t, std::int64_t, int&) override { return {}; }
  void unmap(std::span<const std::uint8_t>) override {}
};

TEST(V4l2Decoders, AreListedByWhatGoesInAndOut) {
  FakeCodec codec;
  for (const auto abilities : {V4L2_CAP_VIDEO_M2M_MPLANE, V4L2_CAP_VIDEO_M2M}) {
    codec.abilities = static_cast<std::uint32_t>(abilities);
    const auto decoder = decoder_of(codec);
    ASSERT_TRUE(decoder);
    EXPECT_EQ(decoder->driver, "bcm2835-codec");
    EXPECT_THAT(decoder->from, ElementsAre("H264", "MJPG"));
    EXPECT_THAT(decoder->to, ElementsAre("NV12"));
  }
}

TEST(V4l2Decoders, AreNeitherCamerasNorEncodersNorScalers) {
  FakeCodec camera, encoder, scaler, other;
  camera.abilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  encoder.in = {{V4L2_PIX_FMT_NV12}};
  encoder.out = {{V4L2_PIX_FMT_H264, true}};
  scaler.in = scaler.out = {{V4L2_PIX_FMT_YUYV}};
  other.refuses = ENOTTY;
  for (auto* device : {&camera, &encoder, &scaler, &other}) EXPECT_FALSE(decoder_of(*device));
}

TEST(V4l2Decoders, ADriverThatListsForEverIsLeft) {
  FakeCodec codec;
  codec.endless = true;
  codec.driver = std::string(40, '\x01');  // no end
  const auto decoder = decoder_of(codec);
  ASSERT_TRUE(decoder);
  EXPECT_EQ(decoder->driver, "????????????????");
  EXPECT_THAT(decoder->from, ElementsAre("H264", "MJPG"));
}

}  // namespace
}  // namespace kasumi
