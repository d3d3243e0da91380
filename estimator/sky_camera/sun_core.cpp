#include "estimator/sky_camera/sun_core.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {

namespace {

constexpr int kLargestRadius = 40;    // elements
constexpr int kElementsForShape = 6;  // of fewer the shape means nothing

struct Window {
  int left, top, right, bottom;  // exclusive
  int step;                      // large ones are sampled more coarsely
};

// The elements within reach of a direction, or a box around them.
std::optional<Window> window_around(const SkyPicture& picture, const Camera& camera, const SunDirection& near,
                                    Radians reach) {
  const auto middle = camera.pixel_of(near);
  if (!middle) return std::nullopt;
  const auto aside = camera.direction_at(*middle + glm::dvec2{picture.step, 0.0});
  const auto below = camera.direction_at(*middle + glm::dvec2{0.0, picture.step});
  if (!aside || !below) return std::nullopt;
  const double element = std::min(angle_between(near, *aside).value, angle_between(near, *below).value);
  if (!(element > 0.0)) return std::nullopt;
  const int radius = std::max(3, static_cast<int>(std::ceil(reach.value / element)));
  const glm::ivec2 centre(glm::round((*middle - picture.first) / picture.step));
  const Window window{std::max(0, centre.x - radius), std::max(0, centre.y - radius),
                      std::min(picture.encoded.width(), centre.x + radius + 1),
                      std::min(picture.encoded.height(), centre.y + radius + 1), 1 + radius / kLargestRadius};
  if (window.right - window.left < 3 || window.bottom - window.top < 3) return std::nullopt;
  return window;
}

}  // namespace

std::optional<SunCore> sun_core(const SkyPicture& picture, const Camera& camera, const SunDirection& near,
                                Radians reach, double saturated, double rim) {
  const auto window = window_around(picture, camera, near, reach);
  if (!window) return std::nullopt;
  const int step = window->step;
  const int width = (window->right - window->left) / step, height = (window->bottom - window->top) / step;
  if (width < 3 || height < 3) return std::nullopt;
  cv::Mat1f level(height, width, 0.0f);
  float brightest = 0.0f;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3& e = picture.encoded.at(window->left + step * x, window->top + step * y);
      level(y, x) = std::min({e.r, e.g, e.b});
      brightest = std::max(brightest, level(y, x));
    }
  const double top = std::min(saturated, static_cast<double>(brightest));
  if (top <= 10.0 * picture.quantum) return std::nullopt;
  cv::Mat1i labels, stats;
  cv::Mat1d centroids;
  cv::Mat1b bright;
  cv::compare(level, rim * top, bright, cv::CMP_GE);
  const int count = cv::connectedComponentsWithStats(bright, labels, stats, centroids, 8, CV_32S);

  struct Part {
    glm::dvec3 direction;
    double weight;
  };
  std::optional<SunCore> best;
  double best_merit = 0.0;
  for (int label = 1; label < count; ++label) {
    const int left = stats(label, cv::CC_STAT_LEFT), upper = stats(label, cv::CC_STAT_TOP);
    const int right = left + stats(label, cv::CC_STAT_WIDTH), lower = upper + stats(label, cv::CC_STAT_HEIGHT);
    if (left == 0 || upper == 0 || right == width || lower == height) continue;
    std::vector<Part> parts;
    glm::dvec3 sum{0.0};
    double weights = 0.0, peak = 0.0;
    for (int y = upper; y < lower; ++y)
      for (int x = left; x < right; ++x) {
        if (labels(y, x) != label) continue;
        const auto here = static_cast<double>(level(y, x));
        const double weight = std::clamp((here / top - rim) / (1.0 - rim), 0.0, 1.0);
        const auto direction =
            camera.direction_at(picture.camera_pixel(window->left + step * x, window->top + step * y));
        if (!direction || weight <= 0.0) continue;
        parts.push_back({*direction, weight});
        sum += weight * *direction;
        weights += weight;
        peak = std::max(peak, here);
      }
    if (weights <= 0.0) continue;
    SunCore core;
    core.direction = glm::normalize(sum);
    core.level = peak;
    const double away = angle_between(core.direction, near).value / reach.value;
    const double merit = std::min(weights, 20.0) / (1.0 + 9.0 * away * away);
    if (merit <= best_merit) continue;
    const glm::dvec3 other = std::abs(core.direction.z) < 0.9 ? glm::dvec3{0.0, 0.0, 1.0} : glm::dvec3{1.0, 0.0, 0.0};
    const glm::dvec3 a = glm::normalize(glm::cross(core.direction, other)), b = glm::cross(core.direction, a);
    double aa = 0.0, ab = 0.0, bb = 0.0;
    for (const Part& part : parts) {
      const double u = glm::dot(part.direction, a), v = glm::dot(part.direction, b);
      aa += part.weight * u * u;
      ab += part.weight * u * v;
      bb += part.weight * v * v;
    }
    const double mean = 0.5 * (aa + bb), half = std::hypot(0.5 * (aa - bb), ab);
    // Of an even disc the mean square of the distance is half the radius' square.
    core.radius = Radians{std::sqrt(2.0 * (aa + bb) / weights)};
    if (static_cast<int>(parts.size()) > kElementsForShape)
      core.roundness = std::sqrt(std::max(0.0, mean - half) / (mean + half));
    best = core;
    best_merit = merit;
  }
  return best;
}

}  // namespace kasumi
