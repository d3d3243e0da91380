#include "pipeline/files/photograph_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <span>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/picture_header.hpp"
#include "capture/codec/jpeg.hpp"

namespace kasumi {

namespace {

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() > 2 && bytes[0] == 0xFF && bytes[1] == 0xD8;
}

Result<cv::Mat> decode_file(const std::filesystem::path& path, std::string* damage) {
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  const auto header = picture_header(*bytes);
  if (header)
    if (auto bounded = check_size(*header, kPhotographLimits); !bounded)
      return fail(FaultKind::bad_input, "{}: {}", path.string(), bounded.error().message);
  cv::Mat image;
  try {
    if (header) image = cv::imdecode(*bytes, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    return fail(FaultKind::bad_input, "{}: not a picture that can be read: {}", path.string(), error.err);
  }
  if (image.empty())
    return fail(FaultKind::bad_input, "{}: not a picture that can be read (expected PNG, JPEG, TIFF or PNM)",
                path.string());
  // OpenCV makes grey of what is missing, without a word.
  if (damage) damage->clear();
  if (is_jpeg(*bytes))
    if (const auto whole = check_jpeg(*bytes); !whole) {
      if (!damage) return fail(FaultKind::bad_input, "{}: {}", path.string(), whole.error().message);
      *damage = whole.error().message;
    }
  return image;
}

}  // namespace

Result<Photograph> read_photograph(const std::filesystem::path& path, std::string* damage) {
  auto image = decode_file(path, damage);
  if (!image) return fail(image.error());
  cv::Mat rgb;
  switch (image->channels()) {
    case 1: cv::cvtColor(*image, rgb, cv::COLOR_GRAY2RGB); break;
    case 3: cv::cvtColor(*image, rgb, cv::COLOR_BGR2RGB); break;
    case 4: cv::cvtColor(*image, rgb, cv::COLOR_BGRA2RGB); break;
    default: return fail(FaultKind::bad_input, "{}: {} channels, expected 1, 3 or 4", path.string(), image->channels());
  }

  Photograph photograph;
  double scale = 1.0;
  switch (rgb.depth()) {
    case CV_8U: scale = photograph.quantum = 1.0 / 255.0; break;
    case CV_16U: scale = photograph.quantum = 1.0 / 65535.0; break;
    case CV_32F:
    case CV_64F: {
      double largest = 0.0;
      cv::patchNaNs(rgb, 0.0);
      cv::minMaxLoc(rgb.reshape(1), nullptr, &largest);
      scale = largest > 0.0 && std::isfinite(largest) ? 1.0 / largest : 1.0;
      break;
    }
    default: return fail(FaultKind::bad_input, "{}: expected 8 or 16 bits or floating point", path.string());
  }
  photograph.encoded = Image<glm::vec3>(rgb.cols, rgb.rows);
  cv::Mat target(rgb.rows, rgb.cols, CV_32FC3, photograph.encoded.elements().data());
  rgb.convertTo(target, CV_32FC3, scale);
  if (image->channels() == 4 && photograph.quantum > 0.0) {
    photograph.opacity = Image<float>(rgb.cols, rgb.rows);
    cv::Mat alpha, opacity(rgb.rows, rgb.cols, CV_32FC1, photograph.opacity.elements().data());
    cv::extractChannel(*image, alpha, 3);
    alpha.convertTo(opacity, CV_32FC1, scale);
  }
  return photograph;
}

Result<> write_photograph(const std::filesystem::path& path, const Photograph& photograph) {
  auto extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool jpeg = extension == ".jpg" || extension == ".jpeg";
  if (!jpeg && extension != ".png" && extension != ".tif" && extension != ".tiff")
    return fail(FaultKind::bad_input, "{}: expected a name that ends in .png, .jpg or .tiff", path.string());
  const bool fine = !jpeg && photograph.quantum < 1.0 / 255.0;
  const auto& encoded = photograph.encoded;
  cv::Mat picture(encoded.height(), encoded.width(), fine ? CV_16UC3 : CV_8UC3);
  const float largest = fine ? 65535.0F : 255.0F;
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        const auto value = std::lround(largest * std::clamp(encoded.at(x, y)[c], 0.0F, 1.0F));
        if (fine)
          picture.at<cv::Vec3w>(y, x)[2 - c] = static_cast<std::uint16_t>(value);
        else
          picture.at<cv::Vec3b>(y, x)[2 - c] = static_cast<std::uint8_t>(value);
      }
  std::vector<std::uint8_t> bytes;
  try {
    if (!cv::imencode(extension, picture, bytes,
                      jpeg ? std::vector{int{cv::IMWRITE_JPEG_QUALITY}, 95} : std::vector<int>{}))
      return fail(FaultKind::io, "{}: cannot be encoded", path.string());
  } catch (const cv::Exception& error) {
    return fail(FaultKind::io, "{}: cannot be encoded: {}", path.string(), error.err);
  }
  return write_file(path, bytes);
}

}  // namespace kasumi
