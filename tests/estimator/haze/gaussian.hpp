// What a blur should be, by OpenCV, and how far from it a picture is.
#pragma once

#include <cmath>

#include <glm/vec4.hpp>
#include <opencv2/imgproc.hpp>

#include "base/image.hpp"

namespace kasumi {

inline Image<glm::vec4> gaussian(Image<glm::vec4> picture, double variance_px2) {
  Image<glm::vec4> blurred(picture.width(), picture.height());
  const cv::Mat from(picture.height(), picture.width(), CV_32FC4, picture.elements().data());
  cv::Mat to(picture.height(), picture.width(), CV_32FC4, blurred.elements().data());
  cv::GaussianBlur(from, to, {}, std::sqrt(variance_px2), 0.0, cv::BORDER_REFLECT);
  return blurred;
}

// Of the colours' differences.
inline double rms(const Image<glm::vec4>& one, const Image<glm::vec4>& other) {
  double sum = 0.0;
  for (std::size_t i = 0; i < one.elements().size(); ++i) {
    const glm::dvec3 off = glm::dvec3(one.elements()[i]) - glm::dvec3(other.elements()[i]);
    sum += off.r * off.r + off.g * off.g + off.b * off.b;
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(one.elements().size())));
}

}  // namespace kasumi
