#include "gles/model/model_picture.hpp"

#include <cstring>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {

Result<PictureHeader> model_picture_size(std::span<const std::uint8_t> file, int largest) {
  const auto header = picture_header(file);
  if (!header || (header->format != "PNG" && header->format != "JPEG"))
    return fail(FaultKind::bad_input, "neither a PNG nor a JPEG");
  if (auto bounded = check_size(*header, {largest, kPhotographLimits.pixels}); !bounded) return fail(bounded.error());
  return *header;
}

Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest) {
  if (auto size = model_picture_size(file, largest); !size) return fail(size.error());
  cv::Mat decoded, rgba;
  try {
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1, const_cast<std::uint8_t*>(file.data()));
    decoded = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);  // keeps alpha and ignores the EXIF orientation
    if (decoded.empty()) return fail(FaultKind::bad_input, "damaged");
    if (decoded.depth() == CV_16U) decoded.convertTo(decoded, CV_8U, 1.0 / 257.0);
    if (decoded.depth() != CV_8U) return fail(FaultKind::bad_input, "neither 8 nor 16 bits a channel");
    switch (decoded.channels()) {
      case 1: cv::cvtColor(decoded, rgba, cv::COLOR_GRAY2RGBA); break;
      case 3: cv::cvtColor(decoded, rgba, cv::COLOR_BGR2RGBA); break;
      case 4: cv::cvtColor(decoded, rgba, cv::COLOR_BGRA2RGBA); break;
      default: return fail(FaultKind::bad_input, "{} channels: expected 1, 3 or 4", decoded.channels());
    }
  } catch (const std::exception& error) {
    return fail(FaultKind::bad_input, "damaged ({})", error.what());
  }
  Image<glm::u8vec4> image(rgba.cols, rgba.rows);
  for (int y = 0; y < rgba.rows; ++y)
    std::memcpy(image.row(y), rgba.ptr(y), static_cast<std::size_t>(rgba.cols) * sizeof(glm::u8vec4));
  return image;
}

}  // namespace kasumi
