// Our pictures as OpenCV's and back.
#pragma once

#include <filesystem>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

inline Image<Rgb8> rgb_of(const cv::Mat3b& bgr) {
  Image<Rgb8> picture(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) picture.at(x, y) = {bgr(y, x)[2], bgr(y, x)[1], bgr(y, x)[0]};
  return picture;
}
inline cv::Mat3b bgr_of(const Image<Rgb8>& picture) {
  cv::Mat3b bgr(picture.height(), picture.width());
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) bgr(y, x) = {picture.at(x, y).b, picture.at(x, y).g, picture.at(x, y).r};
  return bgr;
}

// 0 x 0 where there is none.
inline Image<Rgb8> read_rgb(const std::filesystem::path& file) {
  return rgb_of(cv::imread(file.string(), cv::IMREAD_COLOR));
}

inline cv::Mat3b through_jpeg(const cv::Mat3b& bgr, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

}  // namespace kasumi
