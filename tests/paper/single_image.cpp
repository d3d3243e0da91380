#include "tests/paper/single_image.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/mask/guided_filter.hpp"

namespace kasumi::paper {
namespace {

// OpenCV's erosion treats pixels outside as brighter than any.
Image<float> smallest_around(Image<float> values, int patch_px) {
  const cv::Mat view(values.height(), values.width(), CV_32F, values.elements().data());
  Image<float> smallest(values.width(), values.height());
  cv::Mat result(values.height(), values.width(), CV_32F, smallest.elements().data());
  cv::erode(view, result, cv::getStructuringElement(cv::MORPH_RECT, {patch_px, patch_px}));
  return smallest;
}

Image<float> within(Image<float> values, double lowest, double highest) {
  for (auto& value : values.elements())
    value = std::clamp(value, static_cast<float>(lowest), static_cast<float>(highest));
  return values;
}

}  // namespace

Image<float> dark_channel(const Image<glm::vec3>& picture, int patch_px) {
  Image<float> smallest(picture.width(), picture.height());
  std::ranges::transform(picture.elements(), smallest.elements().begin(), [](const glm::vec3& v) {
    return std::min({v.r, v.g, v.b});
  });
  return smallest_around(std::move(smallest), patch_px);
}

Image<float> transmission_by_dark_channel(const Image<glm::vec3>& relative, const Image<glm::vec3>& guide,
                                          const DarkChannelOptions& options) {
  auto transmission = dark_channel(relative, options.patch_px);
  for (auto& t : transmission.elements()) t = 1.0F - static_cast<float>(options.kept_haze) * t;
  return within(guided_filter(guide, transmission, options.radius_px, options.epsilon), options.lowest_transmission,
                1.0);
}

glm::dvec3 airlight_by_dark_channel(const Image<glm::vec3>& picture, const DarkChannelOptions& options) {
  const auto dark = dark_channel(picture, options.patch_px);
  std::vector<std::size_t> order(dark.elements().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto count = std::max<std::size_t>(1, order.size() / 1000);
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count), [&](auto a, auto b) {
    return dark.elements()[a] > dark.elements()[b] || (!(dark.elements()[a] < dark.elements()[b]) && a < b);
  });
  const auto brightness = [&](std::size_t i) {
    return glm::dot(picture.elements()[i], glm::vec3(0.299F, 0.587F, 0.114F));
  };
  const auto brightest = std::max_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                                          [&](auto a, auto b) { return brightness(a) < brightness(b); });
  return glm::dvec3(picture.elements()[*brightest]);
}

float depth_by_colour(const glm::vec3& encoded, const ColourAttenuationOptions& options) {
  const float value = std::max({encoded.r, encoded.g, encoded.b}), least = std::min({encoded.r, encoded.g, encoded.b});
  const float saturation = value > 0.0F ? (value - least) / value : 0.0F;
  return static_cast<float>(options.offset + options.of_value * static_cast<double>(value) +
                            options.of_saturation * static_cast<double>(saturation));
}

Image<float> transmission_by_colour(const Image<glm::vec3>& encoded, const ColourAttenuationOptions& options) {
  Image<float> depth(encoded.width(), encoded.height());
  std::ranges::transform(encoded.elements(), depth.elements().begin(),
                         [&](const glm::vec3& v) { return depth_by_colour(v, options); });
  auto transmission =
      guided_filter(encoded, smallest_around(std::move(depth), options.patch_px), options.radius_px, options.epsilon);
  for (auto& t : transmission.elements()) t = std::exp(-static_cast<float>(options.scattering) * t);
  return within(std::move(transmission), options.lowest_transmission, options.highest_transmission);
}

Image<glm::vec3> with_haze_of(const Image<glm::vec3>& relative, const Image<float>& transmission, double thickness) {
  Image<glm::vec3> result(relative.width(), relative.height());
  for (std::size_t i = 0; i < relative.elements().size(); ++i) {
    const float change = std::pow(transmission.elements()[i], static_cast<float>(thickness - 1.0));
    result.elements()[i] = glm::max(1.0F + change * (relative.elements()[i] - 1.0F), 0.0F);
  }
  return result;
}

}  // namespace kasumi::paper
