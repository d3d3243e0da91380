#include "base/picture_files/decode_picture.hpp"

#include <opencv2/imgproc.hpp>

#include "base/picture_files/picture_file.hpp"
#include "base/picture_files/rare_files.hpp"

namespace kasumi {

namespace {

cv::Mat matrix_of(const DecodedFile& file) {
  const int depth = file.bits == 16 ? CV_16U : CV_8U;
  // OpenCV only reads from it.
  return cv::Mat(file.height, file.width, CV_MAKETYPE(depth, file.channels),
                 const_cast<std::uint8_t*>(file.samples.data()))
      .clone();
}

// R G B (A).
Result<cv::Mat> decode_rare(const PictureHeader& header, std::span<const std::uint8_t> bytes) {
  const auto files = rare_files();
  if (!files) return fail(files.error());
  try {
    cv::Mat image = header.format == "HEIF" ? (*files)->decode_heif(bytes) : (*files)->decode(bytes);
    if (image.empty())
      return fail(FaultKind::bad_input,
                  "not a picture that can be read: damaged, an animation, or samples of a rare kind");
    if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
    if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2RGBA);
    return image;
  } catch (const cv::Exception& error) {
    return fail(FaultKind::bad_input, "not a picture that can be read: {}", error.err);
  }
}

}  // namespace

// A JPEG of four colours is left to OpenCV.
Result<cv::Mat> decode_picture_file(const PictureHeader& header, std::span<const std::uint8_t> bytes, bool* whole) {
  if (whole) *whole = false;
  if (header.format != "PNG" && header.format != "JPEG") return decode_rare(header, bytes);
  const auto decoded = header.format == "PNG" ? decode_png(bytes) : decode_jpeg_file(bytes);
  if (decoded) {
    if (whole) *whole = decoded->whole;
    return matrix_of(*decoded);
  }
  if (decoded.error().kind == FaultKind::unsupported) return decode_rare(header, bytes);
  return fail(FaultKind::bad_input, "not a picture that can be read: {}", decoded.error().message);
}

}  // namespace kasumi
