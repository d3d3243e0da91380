// PNG and JPEG files against OpenCV's reading of them.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <tuple>

#include <jpeglib.h>
#include <png.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/picture_files/picture_file.hpp"
#include "base/picture_files/small_jpeg.hpp"
#include "base/picture_header.hpp"

namespace kasumi {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Reddish noise on a slope, so that channels, rows and columns cannot be taken for each other.
Bytes samples_of(int width, int height, int channels, int bits) {
  Bytes samples;
  std::uint32_t state = 12345;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        state = state * 1664525u + 1013904223u;
        const auto value = static_cast<std::uint32_t>(3 * x + 5 * y + 40 * c) + (state >> 28);
        for (int byte = 0; byte < bits / 8; ++byte) samples.push_back(static_cast<std::uint8_t>(value + 7u * byte));
      }
  return samples;
}

struct PngKind {
  int colour, channels, bits;
  bool interlaced = false, transparent = false;
};

Bytes written_png(const PngKind& kind, int width, int height) {
  Bytes file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png)) != 0) return {};
  png_set_write_fn(
      png, &file,
      [](png_structp to, png_bytep from, png_size_t count) {
        auto& bytes = *static_cast<Bytes*>(png_get_io_ptr(to));
        bytes.insert(bytes.end(), from, from + count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), kind.bits, kind.colour,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_color palette[256];
  png_byte alpha[256];
  for (int i = 0; i < 256; ++i) {
    palette[i] = {static_cast<png_byte>(i), static_cast<png_byte>(255 - i), static_cast<png_byte>(i * 7)};
    alpha[i] = static_cast<png_byte>(3 * i);
  }
  if (kind.colour == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 1 << kind.bits);
  png_color_16 one{0, 20, 60, 100, 20};
  if (kind.transparent)
    png_set_tRNS(png, info, alpha, kind.colour == PNG_COLOR_TYPE_PALETTE ? 1 << kind.bits : 1, &one);
  png_set_gAMA(png, info, 0.3);  // values are to stay as they are
  const int row_bytes = (width * kind.channels * kind.bits + 7) / 8;
  Bytes samples = samples_of(row_bytes, height, 1, 8);
  std::vector<png_bytep> rows;
  for (int y = 0; y < height; ++y) rows.push_back(samples.data() + static_cast<std::ptrdiff_t>(y) * row_bytes);
  png_write_info(png, info);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

Bytes written_cmyk(int width, int height) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 4;
  jpeg.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  Bytes row = samples_of(width, 1, 4, 8);
  JSAMPROW first = row.data();
  while (jpeg.next_scanline < jpeg.image_height) jpeg_write_scanlines(&jpeg, &first, 1);
  jpeg_finish_compress(&jpeg);
  Bytes file(bytes, bytes + size);
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  return file;
}

// Against OpenCV, whose order is B G R (A).
void expect_as_opencv_reads_it(const DecodedFile& read, const Bytes& file, const std::string& what) {
  cv::Mat seen = cv::imdecode(file, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  ASSERT_FALSE(seen.empty()) << what;
  if (seen.channels() == 3) cv::cvtColor(seen, seen, cv::COLOR_BGR2RGB);
  if (seen.channels() == 4) cv::cvtColor(seen, seen, cv::COLOR_BGRA2RGBA);
  EXPECT_EQ(std::tuple(read.width, read.height, read.channels, read.bits),
            std::tuple(seen.cols, seen.rows, seen.channels(), seen.depth() == CV_16U ? 16 : 8))
      << what;
  const Bytes wanted(seen.datastart, seen.dataend);
  EXPECT_TRUE(read.samples == wanted) << what;
}

TEST(PictureFiles, EveryKindOfPngIsReadAsItStands) {
  const int grey = PNG_COLOR_TYPE_GRAY, both = PNG_COLOR_TYPE_GRAY_ALPHA, rgb = PNG_COLOR_TYPE_RGB,
            rgba = PNG_COLOR_TYPE_RGB_ALPHA, palette = PNG_COLOR_TYPE_PALETTE;
  for (const bool interlaced : {false, true})
    for (const PngKind& kind : std::vector<PngKind>{{grey, 1, 1},
                                                    {grey, 1, 2},
                                                    {grey, 1, 4},
                                                    {grey, 1, 8},
                                                    {grey, 1, 16},
                                                    {both, 2, 8},
                                                    {both, 2, 16},
                                                    {rgb, 3, 8},
                                                    {rgb, 3, 16},
                                                    {rgb, 3, 8, false, true},
                                                    {rgba, 4, 8},
                                                    {rgba, 4, 16},
                                                    {palette, 1, 1},
                                                    {palette, 1, 4},
                                                    {palette, 1, 8},
                                                    {palette, 1, 8, false, true}}) {
      const auto what = fmt::format("colour {}, {} bits{}{}", kind.colour, kind.bits, interlaced ? ", interlaced" : "",
                                    kind.transparent ? ", transparent" : "");
      const Bytes file = written_png({kind.colour, kind.channels, kind.bits, interlaced, kind.transparent}, 37, 23);
      ASSERT_FALSE(file.empty()) << what;
      const auto read = decode_png(file);
      ASSERT_TRUE(read) << what << ": " << read.error().message;
      expect_as_opencv_reads_it(*read, file, what);
    }
}

TEST(PictureFiles, JpegsAreReadAsOpenCvReadsThem) {
  for (const int channels : {1, 3})
    for (const int progressive : {0, 1}) {
      const Bytes samples = samples_of(61, 43, channels, 8);
      const cv::Mat picture(43, 61, CV_MAKETYPE(CV_8U, channels), const_cast<std::uint8_t*>(samples.data()));
      Bytes file;
      ASSERT_TRUE(cv::imencode(".jpg", picture, file,
                               {cv::IMWRITE_JPEG_QUALITY, 70, cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
      const auto read = decode_jpeg_file(file);
      ASSERT_TRUE(read) << read.error().message;
      expect_as_opencv_reads_it(*read, file, fmt::format("{} channels, progressive {}", channels, progressive));
    }
}

TEST(PictureFiles, AJpegAtAnEighthHasTheMeansOfItsPixels) {
  constexpr int kWidth = 61, kHeight = 43;  // no multiples of 8
  cv::Mat3b picture(kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        picture(y, x)[c] = static_cast<std::uint8_t>(60 + x + y / 2 + 20 * c + 7 * (x & y & 1));
  Bytes file;
  ASSERT_TRUE(cv::imencode(".jpg", picture, file, {cv::IMWRITE_JPEG_QUALITY, 90}));
  const auto whole = decode_jpeg_file(file);
  ASSERT_TRUE(whole);
  EXPECT_TRUE(whole->whole);
  const auto small = decode_small_jpeg(file);
  ASSERT_TRUE(small);
  ASSERT_EQ(small->width, (kWidth + 7) / 8);
  ASSERT_EQ(small->height, (kHeight + 7) / 8);
  for (int y = 0; y < kHeight / 8; ++y)
    for (int x = 0; x < kWidth / 8; ++x)
      for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (int j = 8 * y; j < 8 * y + 8; ++j)
          for (int i = 8 * x; i < 8 * x + 8; ++i)
            sum += whole->samples[static_cast<std::size_t>((j * kWidth + i) * 3 + c)];
        const int here = small->samples[static_cast<std::size_t>((y * small->width + x) * 3 + c)];
        EXPECT_NEAR(here, sum / 64.0, 3.0) << x << ' ' << y << ' ' << c;  // chroma is shared by 2 x 2 of them
      }
}

TEST(PictureFiles, WhatIsMissingOfAJpegIsSeenWhileItIsDecoded) {
  const Bytes samples = samples_of(160, 120, 3, 8);
  const cv::Mat picture(120, 160, CV_8UC3, const_cast<std::uint8_t*>(samples.data()));
  Bytes file, progressive;
  ASSERT_TRUE(cv::imencode(".jpg", picture, file));
  ASSERT_TRUE(cv::imencode(".jpg", picture, progressive, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() * 2 / 3));
  const auto read = decode_jpeg_file(cut);
  ASSERT_TRUE(read) << "the rest is made grey";
  EXPECT_FALSE(read->whole);
  EXPECT_FALSE(decode_small_jpeg(cut));
  EXPECT_FALSE(decode_small_jpeg(progressive)) << "not as cameras write it";
  EXPECT_FALSE(decode_small_jpeg(written_cmyk(16, 16)));
  EXPECT_FALSE(decode_small_jpeg({}));
}

TEST(PictureFiles, WhatIsDamagedIsRefusedInWords) {
  const Bytes png = written_png({PNG_COLOR_TYPE_RGB, 3, 8}, 37, 23);
  for (const std::size_t left : {std::size_t{0}, std::size_t{20}, png.size() / 2, png.size() - 5}) {
    const auto read = decode_png(std::span(png).first(left));
    ASSERT_FALSE(read) << left;
    EXPECT_EQ(read.error().kind, FaultKind::bad_input);
    EXPECT_EQ(read.error().message, "damaged PNG: the file ends too early");
  }
  Bytes flipped = png;
  flipped[flipped.size() / 2] ^= 0x55;
  EXPECT_FALSE(decode_png(flipped)) << "its sum is wrong";
  EXPECT_FALSE(decode_jpeg_file(std::span(png)));
  EXPECT_FALSE(decode_jpeg_file({}));
}

TEST(PictureFiles, AJpegOfFourColoursIsToldApart) {
  const auto read = decode_jpeg_file(written_cmyk(16, 16));
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::unsupported);
}

TEST(PictureFiles, APngThatIsWrittenHoldsThePicture) {
  Image<Rgb8> colour(31, 17);
  Image<glm::u16vec3> fine(31, 17);
  Image<std::uint8_t> grey(31, 17);
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 31; ++x) {
      colour.at(x, y) = Rgb8(8 * x, 15 * y, x * y);
      fine.at(x, y) = glm::u16vec3(2000 * x, 3000 * y, 100 * x * y + 7);
      grey.at(x, y) = static_cast<std::uint8_t>(5 * x + 7 * y);
    }
  const cv::Mat in_colour = cv::imdecode(encode_png(colour).value(), cv::IMREAD_UNCHANGED);
  const cv::Mat in_fine = cv::imdecode(encode_png(fine).value(), cv::IMREAD_UNCHANGED);
  const cv::Mat in_grey = cv::imdecode(encode_png(grey).value(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(std::tuple(in_colour.type(), in_fine.type(), in_grey.type()), std::tuple(CV_8UC3, CV_16UC3, CV_8UC1));
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 31; ++x) {
      const auto& bgr = in_colour.at<cv::Vec3b>(y, x);
      const auto& wide = in_fine.at<cv::Vec3w>(y, x);
      ASSERT_EQ(Rgb8(bgr[2], bgr[1], bgr[0]), colour.at(x, y));
      ASSERT_EQ(glm::u16vec3(wide[2], wide[1], wide[0]), fine.at(x, y));
      ASSERT_EQ(in_grey.at<std::uint8_t>(y, x), grey.at(x, y));
    }
  EXPECT_FALSE(encode_png(Image<Rgb8>{}));
}

// Of any size, and of pixels that do not shrink.
TEST(PictureFiles, APngOfNoiseHoldsEachPixel) {
  std::uint32_t state = 7;
  for (const auto& [width, height] : {std::pair(1, 1), {1, 300}, {300, 1}, {640, 480}}) {
    Image<glm::u8vec4> noise(width, height);
    for (auto& pixel : noise.elements())
      for (int c = 0; c < 4; ++c) pixel[c] = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
    const auto read = decode_png(encode_png(noise).value());
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(std::tuple(read->width, read->height, read->channels, read->bits), std::tuple(width, height, 4, 8));
    EXPECT_EQ(std::memcmp(read->samples.data(), noise.elements().data(), read->samples.size()), 0)
        << width << " x " << height;
  }
}

// The size that is bounded before decoding is the one that is decoded.
TEST(PictureFiles, APngWhoseSizeStandsElsewhereIsRefused) {
  Bytes file = written_png({PNG_COLOR_TYPE_RGB, 3, 8}, 40, 30);
  // A chunk of another kind that looks like a size of 1 x 1, before the true one; libpng would skip it.
  const Bytes chunk{0, 0, 0, 8, 'a', 'a', 'A', 'a', 0, 0, 0, 1, 0, 0, 0, 1, 0x6d, 0x7c, 0x5f, 0x3a};
  file.insert(file.begin() + 8, chunk.begin(), chunk.end());
  EXPECT_FALSE(picture_header(file));
  const auto decoded = decode_png(file);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().kind, FaultKind::bad_input);
  EXPECT_NE(decoded.error().message.find("no size"), std::string::npos) << decoded.error().message;
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their shadows need an unbounded address space
[[noreturn]] void decode_in_little_memory(const Bytes& png) {
  rlimit memory{};
  memory.rlim_cur = memory.rlim_max = 512u << 20;
  setrlimit(RLIMIT_AS, &memory);
  const auto read = decode_png(png);
  std::fprintf(stderr, "%s\n", read ? "read" : read.error().message.c_str());
  std::_Exit(0);
}

// Remarks, profiles, and kinds that libpng does not know.
TEST(PictureFilesDeathTest, MemoryIsNotTakenForAChunkLongerThanTheFile) {
  const Bytes png = written_png({PNG_COLOR_TYPE_RGB, 3, 8}, 40, 30);
  for (const char* kind : {"tEXt", "zTXt", "iTXt", "iCCP", "eXIf", "hIST", "sPLT", "xxxx"}) {
    Bytes file = png;
    const Bytes says{0x65, 0, 0, 0};  // 1.6 GB
    const auto after_size = file.begin() + 33;
    file.insert(file.insert(after_size, says.begin(), says.end()) + 4, kind, kind + 4);
    EXPECT_EXIT(decode_in_little_memory(file), testing::ExitedWithCode(0), "damaged PNG: the file ends too early")
        << kind;
  }
}
#endif

}  // namespace
}  // namespace kasumi
