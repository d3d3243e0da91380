#include "estimator/cloud_cover/pixel_features.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "base/fast_log.hpp"
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
  cv::Vec3f top{0, 0, 0}, scale{1, 1, 1};
  const auto each_inside = [&sky](const auto& use) {
    for (int y = 0; y < sky.rgb.rows; ++y) {
      const auto* inside = sky.inside[y];
      const cv::Vec3f* rgb = sky.rgb[y];
      for (int x = 0; x < sky.rgb.cols; ++x)
        if (inside[x]) use(rgb[x]);
    }
  };
  each_inside([&top](const cv::Vec3f& v) {
    for (int c = 0; c < 3; ++c) top[c] = std::max(top[c], v[c]);
  });
  cv::Vec3i at_top{0, 0, 0};
  const cv::Vec3d least{0.99 * static_cast<double>(top[0]), 0.99 * static_cast<double>(top[1]),
                        0.99 * static_cast<double>(top[2])};
  each_inside([&](const cv::Vec3f& v) {
    for (int c = 0; c < 3; ++c) at_top[c] += static_cast<double>(v[c]) >= least[c];
  });
  for (int c = 0; c < 3; ++c)
    if (top[c] > 0.5f && at_top[c] > kPlateau * sky.count) scale[c] = top[c];
  return scale;
}

// Abramowitz and Stegun 4.4.46, without branches: within 1e-6 of acos.
float fast_acos(float cosine) {
  const float x = std::abs(cosine);
  float p = -0.0012624911f;
  p = p * x + 0.0066700901f;
  p = p * x - 0.0170881256f;
  p = p * x + 0.0308918810f;
  p = p * x - 0.0501743046f;
  p = p * x + 0.0889789874f;
  p = p * x - 0.2145988016f;
  p = p * x + 1.5707963050f;
  const float angle = std::sqrt(std::max(0.0f, 1.0f - x)) * p;
  return cosine < 0.0f ? static_cast<float>(kPi) - angle : angle;
}

}  // namespace

bool PixelDirections::fits(const SkyPicture& picture) const {
  return direction.cols == picture.encoded.width() && direction.rows == picture.encoded.height() &&
         step == picture.step && first == picture.first;
}

PixelDirections pixel_directions(const SkyPicture& picture, const Camera& camera) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  PixelDirections sky;
  sky.step = picture.step;
  sky.first = picture.first;
  sky.direction = directions_of(picture, camera);
  sky.inside = cv::Mat1b::zeros(height, width);
  sky.zenith_deg = cv::Mat1f(height, width, 90.0f);
  const float least = static_cast<float>(std::sin(from_degrees(kLeastElevation).value));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f& d = sky.direction(y, x);
      if (d[2] > 0) sky.zenith_deg(y, x) = std::acos(std::min(d[2], 1.0f)) * kDegrees;
      if (d[2] < least || (!camera.mask.empty() && is_masked(camera, picture.camera_pixel(x, y)))) continue;
      sky.inside(y, x) = 255;
    }
  sky.count = cv::countNonZero(sky.inside);
  const cv::Rect box = cv::boundingRect(sky.inside);
  sky.radius = 0.5 * std::max(box.width, box.height);
  return sky;
}

PixelFeatures pixel_features(const SkyPicture& picture, const PixelDirections& directions) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  PixelFeatures sky;
  // OpenCV only reads from it.
  sky.rgb = cv::Mat3f(height, width,
                      const_cast<cv::Vec3f*>(reinterpret_cast<const cv::Vec3f*>(picture.encoded.elements().data())));
  cv::Mat3f smooth;
  cv::blur(sky.rgb, smooth, {3, 3}, {-1, -1}, cv::BORDER_REPLICATE);
  sky.direction = directions.direction;
  sky.inside = directions.inside;
  sky.zenith_deg = directions.zenith_deg;
  sky.count = directions.count;
  sky.radius = directions.radius;
  sky.clipped = cv::Mat1b::zeros(height, width);
  sky.partly = cv::Mat1b::zeros(height, width);
  sky.light.create(height, width);
  sky.blueness.create(height, width);
  sky.greenness.create(height, width);
  const cv::Vec3f scale = full_scale(sky);
  for (int y = 0; y < height; ++y) {
    const cv::Vec3f *rgb = sky.rgb[y], *means = smooth[y];
    const auto* inside = sky.inside[y];
    auto *clipped = sky.clipped[y], *partly = sky.partly[y];
    float *light = sky.light[y], *blueness = sky.blueness[y], *greenness = sky.greenness[y];
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f &v = rgb[x], &s = means[x];
      light[x] = (v[0] + v[1] + v[2]) / 3;
      const float ratio = (s[0] + 0.01f) / (s[2] + 0.01f);
      blueness[x] = ratio < 1 ? 1 - ratio : std::max(-fast_log(ratio), -0.6f);
      greenness[x] = (2 * s[1] - s[0] - s[2]) / (s[0] + s[1] + s[2] + 0.06f);
    }
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f& v = rgb[x];
      const float r = v[0] / scale[0], g = v[1] / scale[1], b = v[2] / scale[2];
      const float least = std::min(std::min(r, g), b), most = std::max(std::max(r, g), b);
      clipped[x] = least >= 0.97f ? inside[x] : std::uint8_t{0};
      partly[x] = most >= 0.985f ? inside[x] : std::uint8_t{0};
    }
  }
  return sky;
}

cv::Mat1f sun_distance(const PixelFeatures& sky, const SunDirection& sun) {
  const auto a = static_cast<float>(sun.x), b = static_cast<float>(sun.y), c = static_cast<float>(sun.z);
  cv::Mat1f degrees(sky.direction.size());
  for (int y = 0; y < degrees.rows; ++y) {
    const cv::Vec3f* direction = sky.direction[y];
    const auto* inside = sky.inside[y];
    float* here = degrees[y];
    for (int x = 0; x < degrees.cols; ++x) {
      const cv::Vec3f& d = direction[x];
      const float cosine = std::min(std::max(d[0] * a + d[1] * b + d[2] * c, -1.0f), 1.0f);
      here[x] = inside[x] ? fast_acos(cosine) * kDegrees : 180.0f;
    }
  }
  return degrees;
}

InsideMeans::InsideMeans(const cv::Mat1b& counts, int side) : side_(side) {
  counts.convertTo(weight_, CV_32F, 1.0 / 255.0);
  cv::boxFilter(weight_, total_, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::max(total_, 1e-4, total_);
}

cv::Mat1f InsideMeans::of(const cv::Mat1f& values) const {
  cv::Mat1f mean;
  cv::multiply(values, weight_, mean);
  cv::boxFilter(mean, mean, CV_32F, {side_, side_}, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::divide(mean, total_, mean);
  return mean;
}

int scaled_side(const PixelFeatures& sky, double elements) {
  return std::max(3, static_cast<int>(std::lround(elements * sky.radius / 190.0)) | 1);
}

}  // namespace kasumi
