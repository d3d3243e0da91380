#include "estimator/photograph/picture_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

// Orthonormal, so that equal noise in R, G and B is equal in all three. Columns: the contributions of R, G and B to
// each.
const glm::mat3& to_directions() {
  static const glm::mat3 matrix = [] {
    const float a = 1.0F / std::sqrt(3.0F), b = 1.0F / std::sqrt(2.0F), c = 1.0F / std::sqrt(6.0F);
    return glm::mat3{{a, b, c}, {a, 0.0F, -2.0F * c}, {a, -b, c}};
  }();
  return matrix;
}

constexpr int kRadius_px = 2;  // windows of 5 x 5 pixels
// A window of 25 pixels of pure noise varies by up to twice the noise's variance; anything not well beyond that is
// noise.
constexpr double kNoiseAlone = 3.0;

constexpr double kLeastNoise = 1e-5;  // rounding in floats

cv::Mat window_mean(const cv::Mat& values) {
  cv::Mat mean;
  cv::blur(values, mean, {2 * kRadius_px + 1, 2 * kRadius_px + 1}, {-1, -1}, cv::BORDER_REFLECT_101);
  return mean;
}

}  // namespace

glm::dvec3 noise_of(const Image<glm::vec3>& encoded) {
  // Enough tiles for a tenth of them to be smooth; more cost time alone.
  constexpr int kTile_px = 16, kMostTiles = 5000;
  constexpr double kSmoothest = 0.1;  // of the tiles
  // From the mean of |z| to sigma, through the mask; for pure noise the smoothest tenth of the tiles reads a tenth too
  // low.
  const double unit = std::sqrt(0.5 * 3.14159265) / 6.0 / 0.9;
  const int across = encoded.width() / kTile_px, down = encoded.height() / kTile_px;
  const int every = 1 + across * down / kMostTiles;
  std::array<std::vector<double>, 3> found;
  for (int tile = 0; tile < across * down; tile += every) {
    glm::dvec3 sum{0.0};
    int count = 0;
    const int left = kTile_px * (tile % across), top = kTile_px * (tile / across);
    for (int y = std::max(1, top); y < std::min(top + kTile_px, encoded.height() - 1); ++y)
      for (int x = std::max(1, left); x < std::min(left + kTile_px, encoded.width() - 1); ++x) {
        const auto& middle = encoded.at(x, y);
        if (std::max({middle.r, middle.g, middle.b}) >= 1.0F || std::min({middle.r, middle.g, middle.b}) <= 0.0F)
          continue;
        const auto at = [&](int i, int j) { return encoded.at(x + i, y + j); };
        sum += glm::abs(to_directions() * (at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1) -
                                           2.0F * (at(0, -1) + at(-1, 0) + at(1, 0) + at(0, 1)) + 4.0F * middle));
        ++count;
      }
    if (count < kTile_px * kTile_px / 2) continue;
    for (int k = 0; k < 3; ++k) found[static_cast<std::size_t>(k)].push_back(unit * sum[k] / count);
  }
  glm::dvec3 sigma{0.0};
  for (int k = 0; k < 3; ++k) {
    auto& tiles = found[static_cast<std::size_t>(k)];
    if (tiles.empty()) continue;
    const auto place = tiles.begin() + static_cast<std::ptrdiff_t>(kSmoothest * static_cast<double>(tiles.size()));
    std::nth_element(tiles.begin(), place, tiles.end());
    if (*place > kLeastNoise) sigma[k] = *place;
  }
  return sigma;
}

Image<glm::vec3> without_noise(const Image<glm::vec3>& encoded, const glm::dvec3& noise) {
  if (noise == glm::dvec3{0.0}) return encoded;
  const int width = encoded.width(), height = encoded.height();
  Image<glm::vec3> clean(width, height);
  for (int k = 0; k < 3; ++k) {
    cv::Mat plane(height, width, CV_32F);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) plane.at<float>(y, x) = (to_directions() * encoded.at(x, y))[k];
    if (noise[k] > 0.0) {
      const double explained = kNoiseAlone * noise[k] * noise[k];
      cv::Mat slope = window_mean(plane.mul(plane)), offset = window_mean(plane);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          auto& own = slope.at<float>(y, x);
          auto& mean = offset.at<float>(y, x);
          const double variance = static_cast<double>(own) - static_cast<double>(mean) * static_cast<double>(mean);
          own = variance > explained ? static_cast<float>(1.0 - explained / variance) : 0.0F;
          mean *= 1.0F - own;
        }
      plane = window_mean(slope).mul(plane) + window_mean(offset);
    }
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) clean.at(x, y)[k] = plane.at<float>(y, x);
  }
  const auto back = glm::transpose(to_directions());
  for (auto& pixel : clean.elements()) pixel = glm::clamp(back * pixel, 0.0F, 1.0F);
  return clean;
}

}  // namespace kasumi
