#include "estimator/sky_camera/sky_slopes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {

namespace {

constexpr int kCoarseSide = 160;        // elements: slopes of the aureole extend over many, and noise averages out
constexpr float kSlowSteepness = 1.0f;  // 1/rad: the sky's own, towards the horizon and across clouds
constexpr float kDarkestQuanta = 3.0f;  // steps of the encoding: fewer make a logarithm's slope by rounding
constexpr float kDarkestLight = 1e-3f;  // of full scale: below, a response is uncertain

// Encoded level -> ln light, per channel.
class LogTable {
 public:
  explicit LogTable(const Response& response) {
    for (std::size_t i = 0; i < kLevels; ++i)
      table_[i] = glm::vec3(
          glm::log(glm::max(response.to_light(glm::dvec3{static_cast<double>(i) / (kLevels - 1)}), glm::dvec3{1e-6})));
  }
  float at(float encoded, int channel) const {
    const float place = std::clamp(encoded, 0.0f, 1.0f) * static_cast<float>(kLevels - 1);
    const auto i = std::min(static_cast<std::size_t>(place), kLevels - 2);
    const float rest = place - static_cast<float>(i);
    return table_[i][channel] * (1.0f - rest) + table_[i + 1][channel] * rest;
  }

 private:
  static constexpr std::size_t kLevels = 256;  // nodes between which encoded values are interpolated
  std::array<glm::vec3, kLevels> table_{};
};

bool unmasked(const Camera& camera, const glm::dvec2& pixel) {
  if (camera.mask.empty()) return true;
  const int x = static_cast<int>(std::lround(pixel.x)), y = static_cast<int>(std::lround(pixel.y));
  return camera.mask.contains(x, y) && camera.mask.at(x, y) != 0;
}

// What the slopes are taken of.
struct LogRadiance {
  Image<glm::vec3> log_light;
  Image<glm::u8vec3> usable;  // per channel
};

// Sobel's slopes of the channels that are usable in all nine elements; their mean.
bool slope_at(const LogRadiance& light, int x, int y, glm::vec2& slope) {
  glm::vec2 sum{0.0f};
  int channels = 0;
  for (int c = 0; c < 3; ++c) {
    bool usable = true;
    for (int j = -1; j <= 1 && usable; ++j)
      for (int i = -1; i <= 1; ++i) usable = usable && light.usable.at(x + i, y + j)[c] != 0;
    if (!usable) continue;
    const auto v = [&](int i, int j) { return light.log_light.at(x + i, y + j)[c]; };
    sum.x += v(1, -1) - v(-1, -1) + 2.0f * (v(1, 0) - v(-1, 0)) + v(1, 1) - v(-1, 1);
    sum.y += v(-1, 1) - v(-1, -1) + 2.0f * (v(0, 1) - v(0, -1)) + v(1, 1) - v(1, -1);
    ++channels;
  }
  if (channels == 0) return false;
  slope = sum / (8.0f * static_cast<float>(channels));
  return true;
}

// From the picture's plane to the sphere, which the lens stretches.
bool onto_sphere(const Image<glm::vec3>& direction, int x, int y, const glm::vec2& slope, BrightnessSlope& out) {
  const glm::vec3 along_x = 0.5f * (direction.at(x + 1, y) - direction.at(x - 1, y));
  const glm::vec3 along_y = 0.5f * (direction.at(x, y + 1) - direction.at(x, y - 1));
  const float xx = glm::dot(along_x, along_x), xy = glm::dot(along_x, along_y), yy = glm::dot(along_y, along_y);
  const float area2 = xx * yy - xy * xy;
  if (!(area2 > 1e-3f * xx * yy)) return false;
  const glm::vec2 step{(yy * slope.x - xy * slope.y) / area2, (xx * slope.y - xy * slope.x) / area2};
  out.steepness = glm::length(step.x * along_x + step.y * along_y);
  if (!(out.steepness > 1e-3f)) return false;
  out.place = {static_cast<float>(x), static_cast<float>(y)};
  out.ahead = glm::normalize(step);
  return true;
}

}  // namespace

CoarseMaps coarse_sky(const SkyPicture& picture, const Camera& camera, double saturated) {
  const auto& encoded = picture.encoded;
  const int block = std::max(1, (std::max(encoded.width(), encoded.height()) + kCoarseSide - 1) / kCoarseSide);
  const int width = encoded.width() / block, height = encoded.height() / block;
  CoarseMaps sky;
  sky.shrink = block;
  sky.direction = Image<glm::vec3>(width, height);
  sky.dimmest = Image<float>(width, height);
  sky.open = Image<std::uint8_t>(width, height);
  sky.clipped = Image<std::uint8_t>(width, height);
  LogRadiance light{Image<glm::vec3>(width, height), Image<glm::u8vec3>(width, height)};
  const LogTable table(camera.response);
  const auto clips = static_cast<float>(saturated);
  const float dark = kDarkestQuanta * static_cast<float>(picture.quantum);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::dvec2 place = sky.picture_element({x, y});
      const glm::dvec2 pixel = picture.camera_pixel(place.x, place.y);
      const auto direction = camera.direction_at(pixel);
      if (!direction) continue;
      sky.direction.at(x, y) = glm::vec3(*direction);
      if (direction->z <= 0.0 || !unmasked(camera, pixel)) continue;
      sky.open.at(x, y) = 1;
      bool clipped = false;
      glm::vec3 sum{0.0f}, most{0.0f}, least{1.0f};
      for (int j = 0; j < block; ++j)
        for (int i = 0; i < block; ++i) {
          const glm::vec3& e = encoded.at(block * x + i, block * y + j);
          sum += e;
          clipped = clipped || std::min({e.r, e.g, e.b}) >= clips;
          most = glm::max(most, e);
          least = glm::min(least, e);
        }
      const glm::vec3 mean = sum / static_cast<float>(block * block);
      const auto shading = static_cast<float>(std::log(std::max(1e-3, camera.vignetting.at(pixel))));
      for (int c = 0; c < 3; ++c) {
        const float log_light = table.at(mean[c], c);
        light.log_light.at(x, y)[c] = log_light - shading;
        light.usable.at(x, y)[c] = most[c] < clips && least[c] > dark && log_light > std::log(kDarkestLight) ? 1 : 0;
      }
      const glm::vec3& l = light.log_light.at(x, y);
      sky.dimmest.at(x, y) = std::min({l.r, l.g, l.b});
      sky.clipped.at(x, y) = clipped ? 1 : 0;
    }
  std::vector<float> levels;
  for (std::size_t i = 0; i < sky.open.elements().size(); ++i) {
    if (sky.open.elements()[i] == 0) continue;
    sky.clipped_elements += sky.clipped.elements()[i];
    if (i % 7 == 0) levels.push_back(sky.dimmest.elements()[i]);
  }
  if (!levels.empty()) sky.middle = static_cast<double>(median_in_place(levels));
  for (int y = 1; y + 1 < height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      glm::vec2 slope;
      BrightnessSlope out;
      if (slope_at(light, x, y, slope) && onto_sphere(sky.direction, x, y, slope, out)) sky.slopes.push_back(out);
    }
  if (width < 8 || height < 8) return sky;
  const glm::vec3 a = sky.direction.at(width / 2, height / 2), b = sky.direction.at(width / 2 + 1, height / 2);
  if (a != glm::vec3{0.0f} && b != glm::vec3{0.0f}) sky.resolution = Radians{static_cast<double>(glm::length(a - b))};
  return sky;
}

std::vector<glm::vec2> where_slopes_meet(const CoarseMaps& sky, int most) {
  const int width = sky.open.width(), height = sky.open.height();
  const int longest = static_cast<int>(from_degrees(35.0).value / std::max(1e-3, sky.resolution.value));
  cv::Mat1f votes(height, width, 0.0f);
  for (const BrightnessSlope& slope : sky.slopes) {
    const float s2 = slope.steepness * slope.steepness;
    const float trust = s2 / (s2 + kSlowSteepness * kSlowSteepness);
    if (trust < 0.3f) continue;
    glm::vec2 at = slope.place + 0.5f;
    for (int step = 1; step <= longest; ++step) {
      at += slope.ahead;
      const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
      if (x < 0 || y < 0 || x >= width || y >= height) break;
      votes(y, x) += trust / static_cast<float>(step);  // lines from far away are spread
    }
  }
  cv::GaussianBlur(votes, votes, {}, 1.5);
  std::vector<glm::vec2> places;
  for (int n = 0; n < most; ++n) {
    double best = 0.0;
    cv::Point where;
    cv::minMaxLoc(votes, nullptr, &best, nullptr, &where);
    if (best <= 0.0) break;
    places.push_back({static_cast<float>(where.x), static_cast<float>(where.y)});
    cv::circle(votes, where, 8, cv::Scalar(0.0), cv::FILLED);
  }
  return places;
}

}  // namespace kasumi
