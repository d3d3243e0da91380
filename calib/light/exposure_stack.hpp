// Exposures of one view, dark and flat pictures: what a response, a black level and a vignetting are measured from.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "calib/light/response_fit.hpp"
#include "calib/light/vignetting_fit.hpp"

namespace kasumi {

constexpr std::size_t kStackPixels = 40000;  // that a response is fitted to

struct ExposureStack {
  std::vector<Image<glm::vec3>> pictures;
  std::vector<std::string> names;
  std::vector<double> log_s;
  double quantum = 0.0;
  int width() const { return pictures.front().width(); }
  int height() const { return pictures.front().height(); }
};

// Exposures given or estimated from the pictures, without those at either end that overlap with no other.
struct KnownStack {
  ExposureStack stack;
  KnownExposures exposures;
  std::vector<std::string> left_out;
};

// Without `exposures_s`, estimated from the pictures as if the camera were linear. `percent`: uncertainty of the times.
KnownStack known_exposures(ExposureStack stack, const std::vector<double>& exposures_s, double percent,
                           const glm::dvec3& black, const Image<std::uint8_t>& mask);

// A circle (x, y, radius) as a mask; empty when none is given.
Image<std::uint8_t> circle_mask(const std::vector<double>& circle, const glm::ivec2& size);

struct DarkFrame {
  glm::dvec3 black{0.0};        // mean of the middle half of each channel
  std::vector<glm::ivec2> hot;  // brighter than the rest of their channel by far
  double hot_above = 0.0;       // from that level on
};

// Pictures with the lens covered; none: no black level, nothing hot.
DarkFrame measure_dark_frame(const std::vector<Image<glm::vec3>>& pictures, double quantum);

// Vignetting from evenly lit pictures, over the circle, or the whole picture where none is given.
Result<VignettingFit> fit_flat_fields(const std::vector<Image<glm::vec3>>& flats, const Response& response,
                                      const std::vector<double>& circle, const Image<std::uint8_t>& mask);

}  // namespace kasumi
