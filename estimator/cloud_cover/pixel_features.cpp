#include "estimator/cloud_cover/pixel_features.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "base/units.hpp"

namespace kasumi {

namespace {

// Directions are smooth: the lens is asked at every fourth element, and in between where a corner is out of reach.
constexpr int kCoarse = 4;
constexpr float kDegrees = static_cast<float>(180.0 / kPi);
constexpr double kPlateau = 0.004;

cv::Vec3f direction_at(const SkyPicture& picture, const Camera& camera, int x, int y) {
  const auto direction = camera.direction_at(picture.camera_pixel(x, y));
  if (!direction) return {0, 0, 0};
  return {static_cast<float>(direction->x), static_cast<float>(direction->y), static_cast<float>(direction->z)};
}

cv::Mat3f directions_of(const SkyPicture& picture, const Camera& camera) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  cv::Mat3f coarse((height - 1) / kCoarse + 2, (width - 1) / kCoarse + 2);
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x) coarse(y, x) = direction_at(picture, camera, x * kCoarse, y * kCoarse);
  const cv::Vec3f none{0, 0, 0};
  cv::Mat3f all(height, width);
  for (int y = 0; y < height; ++y) {
    const int cy = y / kCoarse;
    const float fy = static_cast<float>(y % kCoarse) / kCoarse;
    for (int x = 0; x < width; ++x) {
      const int cx = x / kCoarse;
      const float fx = static_cast<float>(x % kCoarse) / kCoarse;
      const cv::Vec3f &a = coarse(cy, cx), &b = coarse(cy, cx + 1), &c = coarse(cy + 1, cx),
                      &d = coarse(cy + 1, cx + 1);
      const int missing = (a == none) + (b == none) + (c == none) + (d == none);
      if (missing == 4)
        all(y, x) = none;
      else if (missing > 0)
        all(y, x) = direction_at(picture, camera, x, y);
      else
        all(y, x) = cv::normalize((a * (1 - fx) + b * fx) * (1 - fy) + (c * (1 - fx) + d * fx) * fy);
    }
  }
  return all;
}

bool is_masked(const Camera& camera, const glm::dvec2& pixel) {
  const int x = static_cast<int>(std::lround(pixel.x)), y = static_cast<int>(std::lround(pixel.y));
  return camera.mask.contains(x, y) && camera.mask.at(x, y) == 0;
}

// Per channel, the level that counts as full scale: 1, or the top of the picture where so many elements are within 1 %
// of it that something clipped them before the picture was dimmed or balanced.
cv::Vec3f full_scale(const PixelFeatures& sky) {
  cv::Vec3f scale{1, 1, 1};
  std::vector<cv::Mat> channels;
  cv::split(sky.rgb, channels);
  for (int c = 0; c < 3; ++c) {
    double top = 0.0;
    cv::minMaxLoc(channels[static_cast<std::size_t>(c)], nullptr, &top, nullptr, nullptr, sky.inside);
    const cv::Mat1b at_top((channels[static_cast<std::size_t>(c)] >= 0.99 * top) & sky.inside);
    if (top > 0.5 && cv::countNonZero(at_top) > kPlateau * sky.count) scale[c] = static_cast<float>(top);
  }
  return scale;
}

}  // namespace

PixelFeatures pixel_features(const SkyPicture& picture, const Camera& camera) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  PixelFeatures sky;
  sky.rgb.create(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3& v = picture.encoded.at(x, y);
      sky.rgb(y, x) = {v.r, v.g, v.b};
    }
  cv::Mat3f smooth;
  cv::blur(sky.rgb, smooth, {3, 3}, {-1, -1}, cv::BORDER_REPLICATE);
  sky.direction = directions_of(picture, camera);
  sky.inside = cv::Mat1b::zeros(height, width);
  sky.clipped = cv::Mat1b::zeros(height, width);
  sky.partly = cv::Mat1b::zeros(height, width);
  sky.zenith_deg = cv::Mat1f(height, width, 90.0f);
  sky.light.create(height, width);
  sky.blueness.create(height, width);
  sky.greenness.create(height, width);
  const float least = static_cast<float>(std::sin(from_degrees(kLeastElevation).value));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f &v = sky.rgb(y, x), &s = smooth(y, x), &d = sky.direction(y, x);
      sky.light(y, x) = (v[0] + v[1] + v[2]) / 3;
      const float ratio = (s[0] + 0.01f) / (s[2] + 0.01f);
      sky.blueness(y, x) = ratio < 1 ? 1 - ratio : std::max(-std::log(ratio), -0.6f);
      sky.greenness(y, x) = (2 * s[1] - s[0] - s[2]) / (s[0] + s[1] + s[2] + 0.06f);
      if (d[2] > 0) sky.zenith_deg(y, x) = std::acos(std::min(d[2], 1.0f)) * kDegrees;
      if (d[2] < least || (!camera.mask.empty() && is_masked(camera, picture.camera_pixel(x, y)))) continue;
      sky.inside(y, x) = 255;
    }
  sky.count = cv::countNonZero(sky.inside);
  const cv::Vec3f scale = full_scale(sky);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!sky.inside(y, x)) continue;
      const cv::Vec3f& v = sky.rgb(y, x);
      const cv::Vec3f share{v[0] / scale[0], v[1] / scale[1], v[2] / scale[2]};
      sky.clipped(y, x) = std::min({share[0], share[1], share[2]}) >= 0.97f ? 255 : 0;
      sky.partly(y, x) = std::max({share[0], share[1], share[2]}) >= 0.985f ? 255 : 0;
    }
  const cv::Rect box = cv::boundingRect(sky.inside);
  sky.radius = 0.5 * std::max(box.width, box.height);
  return sky;
}

cv::Mat1f sun_distance(const PixelFeatures& sky, const SunDirection& sun) {
  const cv::Vec3f towards{static_cast<float>(sun.x), static_cast<float>(sun.y), static_cast<float>(sun.z)};
  cv::Mat1f degrees(sky.direction.size(), 180.0f);
  for (int y = 0; y < degrees.rows; ++y)
    for (int x = 0; x < degrees.cols; ++x)
      if (sky.inside(y, x))
        degrees(y, x) = std::acos(std::clamp(sky.direction(y, x).dot(towards), -1.0f, 1.0f)) * kDegrees;
  return degrees;
}

cv::Mat1f mean_inside(const cv::Mat1f& values, const cv::Mat1b& counts, int side) {
  cv::Mat1f weight, kept, sum, total;
  counts.convertTo(weight, CV_32F, 1.0 / 255.0);
  kept = values.mul(weight);
  cv::boxFilter(kept, sum, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::boxFilter(weight, total, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_CONSTANT);
  return cv::Mat1f(sum / cv::max(total, 1e-4));
}

int scaled_side(const PixelFeatures& sky, double elements) {
  return std::max(3, static_cast<int>(std::lround(elements * sky.radius / 190.0)) | 1);
}

}  // namespace kasumi
