#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "capture/codec/jpeg.hpp"
#include "tests/capture/codec/exotic_jpeg.hpp"
#include "tests/capture/known_frames.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Result<DecodedPicture> decode_jpeg_frame(const Bytes& bytes, int width, int height) {
  return decode(frame_with(kMjpg, width, height, 0, bytes),
                YuvEncoding::bt709_limited);  // which a JPEG decoder must ignore
}

int largest_difference_to_opencv(const Bytes& bytes, const PictureView& picture) {
  const cv::Mat reference = cv::imdecode(bytes, cv::IMREAD_COLOR);
  EXPECT_EQ(reference.cols, picture.width);
  EXPECT_EQ(reference.rows, picture.height);
  int largest = 0;
  for (int y = 0; y < reference.rows; ++y)
    for (int x = 0; x < reference.cols; ++x) {
      const auto& bgr = reference.at<cv::Vec3b>(y, x);
      const auto rgb = rgb_at(picture, x, y);
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(rgb[c] - bgr[2 - c]));
    }
  return largest;
}

Bytes jpeg_of(int width, int height, ChromaSubsampling subsampling = ChromaSubsampling::s420) {
  return encode_jpeg(test_picture(width, height), 92, subsampling).value();
}

// OpenCV interpolates chroma, we take the nearest sample: on slowly changing colours they agree within 2/255.
TEST(Jpeg, EverySubsamplingAndOddSizeDecodesAsInOpenCv) {
  const std::vector<std::pair<ChromaSubsampling, PixelLayout>> kinds{{ChromaSubsampling::s420, PixelLayout::i420},
                                                                     {ChromaSubsampling::s422, PixelLayout::i422},
                                                                     {ChromaSubsampling::s444, PixelLayout::i444},
                                                                     {ChromaSubsampling::grey, PixelLayout::grey8}};
  for (const auto& [kind, layout] : kinds)
    for (const auto& [width, height] : {std::pair{64, 48}, std::pair{33, 17}, std::pair{1, 1}, std::pair{101, 50},
                                        std::pair{16, 31}, std::pair{2, 64}}) {
      const auto bytes = jpeg_of(width, height, kind);
      const auto picture = must(decode_jpeg_frame(bytes, width, height));
      EXPECT_EQ(picture->view().layout, layout);
      EXPECT_EQ(picture->view().encoding, YuvEncoding::bt601_full);
      EXPECT_LE(largest_difference_to_opencv(bytes, picture->view()), 2) << width << "x" << height;
    }
}

TEST(Jpeg, HighQualityReproducesTheEncodedPicture) {
  const auto image = test_picture(40, 30);
  const auto picture = must(decode_jpeg_frame(encode_jpeg(image, 100, ChromaSubsampling::s444).value(), 40, 30));
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb_at(picture->view(), x, y)[c], image.at(x, y)[c], 3);
}

TEST(Jpeg, ItsStepsAreThoseOfItsTables) {
  // ITU-T T.81 K.1 and K.2 at libjpeg's quality 50: as printed; at 25, twice as much, at 100, 1.
  const auto steps_of = [](int quality, ChromaSubsampling subsampling) {
    const auto bytes = encode_jpeg(Image<Rgb8>(33, 17, Rgb8(90)), quality, subsampling).value();
    return decode_jpeg(bytes, 33, 17).value().steps;
  };
  const auto half = steps_of(50, ChromaSubsampling::s420), quarter = steps_of(25, ChromaSubsampling::s444);
  const std::array<std::uint16_t, 8> luma{16, 11, 10, 16, 24, 40, 51, 61}, chroma{17, 18, 24, 47, 99, 99, 99, 99};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(half.luma[i], luma[i]) << "the first row, not the first column";
    EXPECT_EQ(half.chroma[i], chroma[i]);
    EXPECT_EQ(quarter.luma[i], 2 * luma[i]);
  }
  EXPECT_EQ(half.luma[63], 99);
  EXPECT_EQ(steps_of(100, ChromaSubsampling::s422).luma[40], 1);
  const auto grey = steps_of(50, ChromaSubsampling::grey);
  EXPECT_EQ(grey.chroma, grey.luma);
}

TEST(Jpeg, SamplingFactorsWithACommonMultipleAreReduced) {
  const auto image = test_picture(37, 29);
  const auto odd_422 = exotic_jpeg(image, [](jpeg_compress_struct& info) {  // as ffmpeg writes 4:2:2
    info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 2;
    info.comp_info[1].v_samp_factor = info.comp_info[2].v_samp_factor = 2;
  });
  const auto odd_444 = exotic_jpeg(image, [](jpeg_compress_struct& info) {
    for (int i = 0; i < 3; ++i) info.comp_info[i].h_samp_factor = 1, info.comp_info[i].v_samp_factor = 2;
  });
  for (const auto& [bytes, layout] : {std::pair{odd_422, PixelLayout::i422}, std::pair{odd_444, PixelLayout::i444}}) {
    const auto picture = must(decode_jpeg_frame(bytes, 37, 29));
    EXPECT_EQ(picture->view().layout, layout);
    EXPECT_LE(largest_difference_to_opencv(bytes, picture->view()), 2);
  }
}

TEST(Jpeg, RestartMarkersAndMissingHuffmanTablesChangeNothing) {
  const auto image = test_picture(64, 48);
  const auto plain = exotic_jpeg(image, [](jpeg_compress_struct&) {});
  const auto restarts = exotic_jpeg(image, [](jpeg_compress_struct& info) { info.restart_interval = 2; });
  const auto tableless = without_huffman_tables(plain);
  ASSERT_GT(restarts.size(), plain.size());
  ASSERT_LT(tableless.size() + 100, plain.size());
  const auto expected = to_rgb(decode_jpeg_frame(plain, 64, 48).value().view()).elements();
  for (const auto& bytes : {restarts, tableless}) {
    const auto picture = must(decode_jpeg_frame(bytes, 64, 48));
    EXPECT_EQ(to_rgb(picture->view()).elements(), expected);
  }
}

TEST(Jpeg, PaddingAndAMissingEndMarkerAreTolerated) {
  const auto whole = jpeg_of(64, 48);
  const auto expected = to_rgb(decode_jpeg_frame(whole, 64, 48).value().view()).elements();
  auto padded = whole;
  padded.resize(padded.size() + 500);
  padded.insert(padded.begin() + 2, {0, 0, 0});  // between the first two segments
  const Bytes endless(whole.begin(), whole.end() - 2);
  for (const auto& bytes : {padded, endless}) {
    const auto picture = must(decode_jpeg_frame(bytes, 64, 48));
    EXPECT_EQ(to_rgb(picture->view()).elements(), expected);
  }
}

TEST(Jpeg, ATruncatedJpegIsDamagedWhereverItIsCut) {
  const auto whole = jpeg_of(64, 48);
  for (std::size_t length = 1; length + 8 < whole.size(); ++length)
    ASSERT_FALSE(decode_jpeg_frame(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)), 64, 48))
        << "cut after " << length << " of " << whole.size();
  const auto half = decode_jpeg_frame(Bytes(whole.begin(), whole.begin() + 1200), 64, 48);
  EXPECT_THAT(half.error().message, HasSubstr("damaged JPEG: Corrupt JPEG data: premature end"));
}

TEST(Jpeg, AHoleInTheMiddleIsDamaged) {
  auto bytes = exotic_jpeg(test_picture(64, 48), [](jpeg_compress_struct& info) { info.restart_interval = 2; });
  bytes.erase(bytes.begin() + 1000, bytes.begin() + 1400);  // a lost USB packet
  EXPECT_FALSE(decode_jpeg_frame(bytes, 64, 48));
}

TEST(Jpeg, AnUnexpectedSizeIsReported) {
  const auto refused = decode_jpeg_frame(jpeg_of(64, 48), 640, 480);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_EQ(refused.error().message, "JPEG size 64x48: expected 640x480");
}

TEST(Jpeg, JpegsThatNoCameraSendsAreRefusedByName) {
  const auto image = test_picture(32, 32);
  const auto message = [&](const std::function<void(jpeg_compress_struct&)>& change) {
    const auto refused = decode_jpeg_frame(exotic_jpeg(image, change), 32, 32);
    return refused ? std::string("accepted") : refused.error().message;
  };
  EXPECT_THAT(message([](auto& info) { jpeg_simple_progression(&info); }), HasSubstr("several scans"));
  EXPECT_THAT(message([](auto& info) { info.arith_code = TRUE; }), HasSubstr("arithmetic"));
  EXPECT_THAT(message([](auto& info) { jpeg_set_colorspace(&info, JCS_RGB); }), HasSubstr("not YCbCr"));
  EXPECT_THAT(message([](auto& info) {
                info.input_components = 4;
                info.in_color_space = JCS_CMYK;
                jpeg_set_colorspace(&info, JCS_CMYK);
              }),
              HasSubstr("4 components"));
  EXPECT_THAT(message([](auto& info) { info.comp_info[0].h_samp_factor = 4; }), HasSubstr("sampling 4x2,1x1,1x1"));
}

// What other programs fill with grey in silence.
TEST(Jpeg, AMissingPartIsNoticedOfAnyKindOfJpeg) {
  const auto image = test_picture(160, 120);
  cv::Mat bgr(120, 160, CV_8UC3);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const auto& c = image.at(x, y);
      bgr.at<cv::Vec3b>(y, x) = {c.b, c.g, c.r};
    }
  Bytes progressive, grey;
  ASSERT_TRUE(cv::imencode(".jpg", bgr, progressive, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  cv::Mat one;
  cv::extractChannel(bgr, one, 1);
  ASSERT_TRUE(cv::imencode(".jpg", one, grey));
  for (const auto& whole : {jpeg_of(160, 120), jpeg_of(160, 120, ChromaSubsampling::s444), progressive, grey}) {
    EXPECT_TRUE(check_jpeg(whole)) << check_jpeg(whole).error().message;
    for (const double share : {0.3, 0.5, 0.9, 0.98}) {
      const Bytes cut(whole.begin(),
                      whole.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(whole.size())));
      EXPECT_FALSE(check_jpeg(cut)) << share;
    }
  }
  progressive.resize(progressive.size() - 2);  // it may have had more
  EXPECT_THAT(check_jpeg(progressive), FailsWith(HasSubstr("its finer scans are missing")));
  Bytes unended = jpeg_of(160, 120);
  unended.resize(unended.size() - 2);
  EXPECT_TRUE(check_jpeg(unended)) << "some cameras write no end marker";
  EXPECT_FALSE(check_jpeg(Bytes{}));
  EXPECT_FALSE(check_jpeg(Bytes(3000, 'a')));
}

TEST(Jpeg, BytesThatAreNotAJpegAreRefused) {
  EXPECT_THAT(decode_jpeg_frame(Bytes(3000, 'a'), 64, 48).error().message, HasSubstr("Not a JPEG"));
}

TEST(Jpeg, AFewBytesCannotClaimTheMemoryOfAHugePicture) {
  auto bytes = jpeg_of(64, 48);
  for (std::size_t at = 0; at + 8 < bytes.size(); ++at)
    if (bytes[at] == 0xFF && bytes[at + 1] == 0xC0) {  // the frame header: height and width follow
      bytes[at + 5] = 0x10;                            // 8256 x 4144 pixels
      bytes[at + 7] = 0x20;
      break;
    }
  EXPECT_THAT(decode_jpeg_frame(bytes, 0x2040, 0x1030), FailsWith(HasSubstr("bytes: expected at least")));
}

TEST(Jpeg, PicturesThatCannotBeEncodedAreRefused) {
  EXPECT_FALSE(encode_jpeg(Image<Rgb8>(), 90, ChromaSubsampling::s420));
  EXPECT_FALSE(encode_jpeg(test_picture(8, 8), 0, ChromaSubsampling::s420));
  EXPECT_FALSE(encode_jpeg(test_picture(8, 8), 101, ChromaSubsampling::s420));
  EXPECT_FALSE(encode_jpeg(Image<Rgb8>(70000, 1), 90, ChromaSubsampling::s420));
}

}  // namespace
}  // namespace kasumi
