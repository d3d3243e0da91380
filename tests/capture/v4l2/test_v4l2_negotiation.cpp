// Requests to a driver, and how its answers are interpreted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <linux/v4l2-controls.h>

#include <cerrno>

#include "capture/v4l2/formats.hpp"
#include "capture/v4l2/offer.hpp"
#include "tests/capture/known_frames.hpp"
#include "tests/capture/v4l2/fake_camera.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class V4l2Negotiation : public testing::Test {
 protected:
  Result<std::unique_ptr<CameraSource>> open(FakeCamera& camera) {
    return open_v4l2_source(camera.open(), {device, request}, clock);
  }
  CameraMode mode(FakeCamera& camera) {
    auto source = open(camera);
    EXPECT_TRUE(source) << source.error().message;
    return source ? (*source)->mode() : CameraMode{};
  }
  std::string chosen(std::vector<FakeMode> modes) {
    FakeCamera camera(std::move(modes), clock);
    const auto agreed = mode(camera);
    return fmt::format("{} {:.4g}", agreed.format.text(), agreed.frames_per_second);
  }

  FastForwardClock clock{Utc{}};
  std::filesystem::path device = "/dev/v4l/by-id/fake";
  CameraRequest request{.width = 64, .height = 48};
};

// A webcam: raw formats are slow at this size.
const std::vector<FakeMode> kWebcam{{V4L2_PIX_FMT_YUYV, 64, 48, {{1, 5}}},
                                    {V4L2_PIX_FMT_MJPEG, 64, 48, {{1, 30}, {1, 15}}},
                                    {V4L2_PIX_FMT_YUYV, 32, 24, {{1, 30}}}};
const std::vector<FakeMode> kRich{{V4L2_PIX_FMT_GREY, 64, 48, {{1, 60}}},
                                  {V4L2_PIX_FMT_MJPEG, 64, 48, {{1, 30}}},
                                  {V4L2_PIX_FMT_RGB24, 64, 48, {{1, 30}}},
                                  {V4L2_PIX_FMT_YUYV, 64, 48, {{1001, 30000}, {1, 25}}},
                                  {V4L2_PIX_FMT_NV12, 64, 48, {{1, 15}}}};

TEST_F(V4l2Negotiation, ColourOutranksRateAndRateOutranksCost) {
  request.frames_per_second = 30;
  EXPECT_EQ(chosen(kWebcam), "MJPG 30");
  EXPECT_EQ(chosen(kRich), "YUYV 29.97") << "as fast as JPEG and cheaper, faster than NV12";
  request.frames_per_second = 5;
  EXPECT_EQ(chosen(kWebcam), "YUYV 5");
  request.frames_per_second = 25;
  EXPECT_EQ(chosen(kRich), "YUYV 25");
  request.frames_per_second = 15;
  EXPECT_EQ(chosen(kRich), "NV12 15");
  request.frames_per_second = 0;
  EXPECT_EQ(chosen(kWebcam), "MJPG 30") << "as fast as it can";
  EXPECT_EQ(chosen(kRich), "YUYV 29.97");
}

TEST_F(V4l2Negotiation, ARequestedFormatIsUsed) {
  for (const char* format : {"GREY", "MJPG", "RGB3", "YUYV", "NV12"}) {
    request.format = parse_four_cc(format).value();
    EXPECT_THAT(chosen(kRich), HasSubstr(format));
  }
}

TEST_F(V4l2Negotiation, GreyIsUsedWhereThereIsNothingElse) {
  EXPECT_EQ(chosen({{V4L2_PIX_FMT_GREY, 64, 48}, {V4L2_PIX_FMT_YUYV, 32, 24}}), "GREY 30");
}

TEST_F(V4l2Negotiation, AnUnavailableRateIsReported) {
  request.frames_per_second = 60;
  FakeCamera camera(kWebcam, clock);
  EXPECT_THAT(mode(camera).notes, ElementsAre("frame rate 60 /s requested: the camera delivers 30 /s"));
}

TEST_F(V4l2Negotiation, AnUnavailableSizeIsRefusedWithTheAvailableOnes) {
  request.width = 100;
  request.format = four_cc("YUYV");
  auto modes = kWebcam;
  modes.push_back({V4L2_PIX_FMT_SBGGR10P, 100, 48});
  FakeCamera camera(modes, clock);
  const auto refused = open(camera);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_EQ(refused.error().message,
            "/dev/v4l/by-id/fake: YUYV 100x48: the camera does not offer it; it offers\n"
            "  YUYV: 64x48 (5 /s), 32x24 (30 /s)\n"
            "  MJPG: 64x48 (30, 15 /s)\n"
            "  and, not supported: pBAA");
}

TEST_F(V4l2Negotiation, ADriverThatDoesNotEnumerateItsSizesIsTried) {
  FakeCamera camera({{V4L2_PIX_FMT_YUYV, 32, 24}, {V4L2_PIX_FMT_MJPEG, 64, 48}}, clock);
  camera.enumerates_sizes = false;
  EXPECT_EQ(mode(camera).format, kMjpg);
}

TEST_F(V4l2Negotiation, StepwiseSizesAreEnumerated) {
  const V4l2Sizes sizes{64, 1920, 16, 48, 1080, 2};
  EXPECT_TRUE(sizes.includes(64, 48));
  EXPECT_TRUE(sizes.includes(1920, 1080));
  EXPECT_TRUE(sizes.includes(640, 50));
  EXPECT_FALSE(sizes.includes(650, 50));
  EXPECT_FALSE(sizes.includes(640, 51));
  EXPECT_FALSE(sizes.includes(1936, 1080));
  EXPECT_FALSE(sizes.includes(48, 48));
  EXPECT_TRUE((V4l2Sizes{1, 100, 0, 1, 100, 0}).includes(37, 99)) << "a step of 0 is a driver's mistake for 1";
}

TEST_F(V4l2Negotiation, RatesWithinARangeAreMetExactly) {
  const V4l2Rates rates{{{1, 60}, {1, 5}}, true};
  EXPECT_DOUBLE_EQ(rates.nearest(24.5).rate(), 24.5);
  EXPECT_DOUBLE_EQ(rates.nearest(100).rate(), 60.0);
  EXPECT_DOUBLE_EQ(rates.nearest(1).rate(), 5.0);
  EXPECT_DOUBLE_EQ(rates.nearest(0).rate(), 60.0);
  EXPECT_DOUBLE_EQ(V4l2Rates{}.nearest(30).rate(), 0.0);
}

TEST_F(V4l2Negotiation, AnEndlessEnumerationIsCutOff) {
  FakeCamera camera(kWebcam, clock);
  camera.refuse(VIDIOC_ENUM_FMT, 0);
  camera.refuse(VIDIOC_ENUM_FRAMESIZES, 0);
  camera.refuse(VIDIOC_ENUM_FRAMEINTERVALS, 0);
  EXPECT_FALSE(open(camera));
  EXPECT_LT(camera.calls().size(), 1000u);
}

TEST_F(V4l2Negotiation, AllProblemsOfARequestAreReportedAtOnce) {
  request = {.width = 0,
             .height = 99999,
             .frames_per_second = -1,
             .exposure_s = 0.0,
             .gain = -1.0,
             .white_balance_k = 10.0,
             .buffers = 1};
  FakeCamera camera(kWebcam, clock);
  const auto refused = open(camera);
  ASSERT_FALSE(refused);
  for (const char* key : {"width", "frames_per_second", "exposure_s", "gain", "white_balance_k", "buffers"})
    EXPECT_THAT(refused.error().message, HasSubstr(key));
}

TEST_F(V4l2Negotiation, ADeviceNamedByNumberIsReported) {
  device = "/dev/video0";
  FakeCamera camera(kWebcam, clock);
  EXPECT_THAT(mode(camera).notes, ElementsAre(HasSubstr("may be another camera after the next boot")));
}

TEST_F(V4l2Negotiation, ANonCaptureDeviceIsUnsupported) {
  FakeCamera camera(kWebcam, clock);
  camera.lie([](unsigned long code, void* argument) {
    if (code == VIDIOC_QUERYCAP)
      static_cast<v4l2_capability*>(argument)->device_caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  });
  EXPECT_EQ(open(camera).error().kind, FaultKind::unsupported);
  EXPECT_EQ(open_v4l2_source({"/dev/null", request}, clock).error().kind, FaultKind::unsupported);
  EXPECT_EQ(open_v4l2_source({"/dev/v4l/by-id/nothing", request}, clock).error().kind, FaultKind::disconnected);
  EXPECT_EQ(open_v4l2_source({source_folder() / "README.md", request}, clock).error().kind, FaultKind::unsupported);
}

// By the kernel's documentation (Colorspaces, tables of defaults).
TEST_F(V4l2Negotiation, ColourSpacesAreReadAsV4l2DefinesThem) {
  const auto yuyv = four_cc("YUYV");
  const auto encoding = [&](std::uint32_t space, std::uint32_t ycbcr = 0, std::uint32_t quantization = 0) {
    return v4l2_yuv_encoding(yuyv, space, ycbcr, quantization);
  };
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SMPTE170M), YuvEncoding::bt601_limited);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SRGB), YuvEncoding::bt601_limited);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_JPEG), YuvEncoding::bt601_full);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_REC709), YuvEncoding::bt709_limited);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_REC709, 0, V4L2_QUANTIZATION_FULL_RANGE), YuvEncoding::bt709_full);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_SRGB, V4L2_YCBCR_ENC_709), YuvEncoding::bt709_limited);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_REC709, V4L2_YCBCR_ENC_601, V4L2_QUANTIZATION_FULL_RANGE),
            YuvEncoding::bt601_full);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_JPEG, 0, V4L2_QUANTIZATION_LIM_RANGE), YuvEncoding::bt601_limited);
  EXPECT_EQ(encoding(V4L2_COLORSPACE_DEFAULT), std::nullopt) << "the driver does not specify it";
  EXPECT_EQ(encoding(V4L2_COLORSPACE_BT2020), std::nullopt) << "a matrix we do not support";
  EXPECT_EQ(v4l2_yuv_encoding(kMjpg, V4L2_COLORSPACE_JPEG, 0, 0), std::nullopt);
  EXPECT_EQ(v4l2_yuv_encoding(four_cc("RGB3"), V4L2_COLORSPACE_SRGB, 0, 0), std::nullopt);
}

TEST_F(V4l2Negotiation, ADriverThatContradictsTheCalibrationIsReportedAndOverruled) {
  FakeCamera camera({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  EXPECT_EQ(mode(camera).yuv_encoding, YuvEncoding::bt601_limited);
  EXPECT_THAT(mode(camera).notes, IsEmpty());
  request.yuv_encoding = YuvEncoding::bt601_limited;
  EXPECT_THAT(mode(camera).notes, IsEmpty());
  request.yuv_encoding = YuvEncoding::bt709_full;
  EXPECT_THAT(mode(camera).notes, ElementsAre(AllOf(HasSubstr("yuv_encoding"), HasSubstr("calibration"))));
}

// --- controls

std::map<std::uint32_t, FakeControl> webcam_controls() {
  return {{V4L2_CID_EXPOSURE_AUTO, {0, 3, 1, V4L2_EXPOSURE_APERTURE_PRIORITY, {1, 3}}},
          {V4L2_CID_EXPOSURE_AUTO_PRIORITY, {0, 1, 1, 1}},
          {V4L2_CID_EXPOSURE_ABSOLUTE, {3, 2047, 1, 250}},
          {V4L2_CID_GAIN, {0, 255, 1, 64}},
          {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1, 1}},
          {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2000, 6500, 10, 4000}}};
}

TEST_F(V4l2Negotiation, RequestedControlsAreSetLockedAndReadBack) {
  FakeCamera camera({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  camera.controls = webcam_controls();
  request.exposure_s = 0.0125;
  request.gain = 20.0;
  request.white_balance_k = 5003.0;
  const auto agreed = mode(camera);
  EXPECT_EQ(camera.controls.at(V4L2_CID_EXPOSURE_AUTO).value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera.controls.at(V4L2_CID_EXPOSURE_ABSOLUTE).value, 125) << "of 100 us";
  EXPECT_EQ(camera.controls.at(V4L2_CID_EXPOSURE_AUTO_PRIORITY).value, 0);
  EXPECT_EQ(camera.controls.at(V4L2_CID_GAIN).value, 20);
  EXPECT_EQ(camera.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 0);
  EXPECT_EQ(camera.controls.at(V4L2_CID_WHITE_BALANCE_TEMPERATURE).value, 5000);
  EXPECT_DOUBLE_EQ(*agreed.exposure_s, 0.0125);
  EXPECT_EQ(agreed.gain, 20.0);
  EXPECT_EQ(agreed.white_balance_k, 5000.0);
  EXPECT_THAT(agreed.notes, IsEmpty());
  const auto source = open(camera).value();
  const auto frame = source->next(clock.now() + 1s).value();
  EXPECT_EQ(frame.metadata.exposure_s, agreed.exposure_s);
  EXPECT_EQ(frame.metadata.gain, std::nullopt) << "the driver's units give no factor";
}

TEST_F(V4l2Negotiation, OtherControlsAreLeftToTheCamera) {
  FakeCamera camera({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  camera.controls = webcam_controls();
  camera.controls.at(V4L2_CID_EXPOSURE_AUTO).value = V4L2_EXPOSURE_MANUAL;  // by its previous user
  camera.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value = 0;
  const auto agreed = mode(camera);
  EXPECT_EQ(camera.controls.at(V4L2_CID_EXPOSURE_AUTO).value, V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(camera.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 1);
  EXPECT_EQ(agreed.exposure_s, std::nullopt);
}

TEST_F(V4l2Negotiation, UnsupportedControlsAreReported) {
  request.exposure_s = 1.0;
  request.gain = 2.0;
  request.white_balance_k = 9000.0;
  FakeCamera plain({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  EXPECT_THAT(mode(plain).notes, ElementsAre(HasSubstr("exposure in seconds: the camera has no such control"),
                                             HasSubstr("gain in the driver's units: the camera has no such control"),
                                             HasSubstr("white balance in kelvin: the camera has no such control")));
  FakeCamera narrow({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  narrow.controls = webcam_controls();
  const auto agreed = mode(narrow);
  EXPECT_DOUBLE_EQ(*agreed.exposure_s, 0.2047);
  EXPECT_EQ(agreed.white_balance_k, 6500.0);
  EXPECT_THAT(agreed.notes, ElementsAre(HasSubstr("exposure in seconds 1 requested: the camera uses 0.2047"),
                                        HasSubstr("white balance in kelvin 9000 requested: the camera uses 6500")));
}

TEST_F(V4l2Negotiation, WhiteBalanceIsLockedAtItsValueAfterTheFirstFrames) {
  FakeCamera camera({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  camera.controls = webcam_controls();
  const auto source = open(camera).value();
  camera.controls.at(V4L2_CID_WHITE_BALANCE_TEMPERATURE).value = 5230;
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(source->next(clock.now() + 1s));
  EXPECT_EQ(camera.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 1);
  EXPECT_EQ(source->mode().white_balance_k, std::nullopt);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(source->next(clock.now() + 1s));
  EXPECT_EQ(camera.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 0);
  EXPECT_EQ(source->mode().white_balance_k, 5230.0);

  request.lock_white_balance = false;
  FakeCamera free({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  free.controls = webcam_controls();
  const auto unlocked = open(free).value();
  for (int i = 0; i < 80; ++i) ASSERT_TRUE(unlocked->next(clock.now() + 1s));
  EXPECT_EQ(free.controls.at(V4L2_CID_AUTO_WHITE_BALANCE).value, 1);
}

}  // namespace
}  // namespace kasumi
