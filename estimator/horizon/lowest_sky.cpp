// The lowest visible sky, clear or not: used where clear sky cannot be distinguished from clouds.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "estimator/horizon/strips.hpp"

namespace kasumi {
namespace {

struct Pixel {
  int x = 0, y = 0;
  glm::dvec3 light{0};
  double brightness = 0.0;
  bool clipped = false;
};

Pixel pixel_of(const HorizonPixels& scene, int x, int y) {
  const glm::dvec3 light = scene.light_at(x, y);
  return {x, y, light, (light.x + light.y + light.z) / 3.0, scene.clipped_at(x, y)};
}

struct Measured {
  HorizonColumn column;
  bool clipped = false;
};

std::optional<Measured> measure_strip(const HorizonPixels& scene, const HorizonStrip& strip) {
  const int height = scene.picture.height();
  const int x0 = strip.x0, x1 = strip.x1;
  const int bottom = strip.first_drop - std::max(1, static_cast<int>(kHorizonMargin * height));
  const int top = bottom - std::max(4, static_cast<int>(kHorizonBand * height));
  if (top < 0) return std::nullopt;

  std::vector<Pixel> pixels;
  const int step = std::max(1, (x1 - x0) / 64);
  for (int y = top; y < bottom; ++y) {
    for (int x = x0; x < x1; x += step) {
      if (scene.sky.at(x, y) != 0) pixels.push_back(pixel_of(scene, x, y));
    }
  }
  if (pixels.size() < 16) return std::nullopt;
  const auto clipped = static_cast<std::size_t>(
      std::count_if(pixels.begin(), pixels.end(), [](const Pixel& pixel) { return pixel.clipped; }));
  const bool mostly_clipped = 2 * clipped > pixels.size();
  const std::size_t looked_at = pixels.size();
  if (!mostly_clipped) std::erase_if(pixels, [](const Pixel& pixel) { return pixel.clipped; });

  std::vector<double> brightness;
  for (const Pixel& pixel : pixels) brightness.push_back(pixel.brightness);
  const double centre = median(brightness);
  for (double& value : brightness) value = std::abs(value - centre);
  const double tolerance = std::max(3.0 * kSigmaOverMedianSize * median(brightness), 0.01 * centre);

  Measured measured;
  glm::dvec3 light{0.0};
  glm::dvec3 towards{0.0};
  int count = 0;
  for (const Pixel& pixel : pixels) {
    if (std::abs(pixel.brightness - centre) > tolerance) continue;
    const auto direction = scene.camera.direction_at({pixel.x, pixel.y});
    if (!direction) continue;
    light += pixel.light;
    towards += *direction;
    ++count;
  }
  if (count < 8 || glm::length(towards) == 0.0) return std::nullopt;
  towards = glm::normalize(towards);
  const double agreed = count / static_cast<double>(looked_at);
  measured.column = {azimuth_angle(towards), zenith_angle(towards), light / static_cast<double>(count),
                     mostly_clipped ? 0.1 * agreed : agreed};
  measured.clipped = mostly_clipped;
  return measured;
}

// Logarithm of light as a quadratic in azimuth, plus a slope in zenith angle where the columns were measured at
// different zenith angles (silhouettes). Outlying columns are replaced by the fit; the others keep part of their own
// residual, smoothed.
void smooth_over_azimuth(std::vector<HorizonColumn>& columns) {
  const auto size = static_cast<Eigen::Index>(columns.size());
  if (size < 5) return;
  const Radians middle = columns[columns.size() / 2].azimuth;
  Eigen::VectorXd azimuth(size), zenith(size);
  Eigen::MatrixXd log_light(size, 3);
  for (Eigen::Index i = 0; i < size; ++i) {
    const HorizonColumn& column = columns[static_cast<std::size_t>(i)];
    azimuth[i] = std::remainder(column.azimuth.value - middle.value, 2.0 * kPi);
    zenith[i] = column.zenith.value;
    for (int c = 0; c < 3; ++c) log_light(i, c) = std::log(std::max(column.light[c], 1e-9));
  }
  azimuth /= std::max(azimuth.cwiseAbs().maxCoeff(), 1e-9);
  zenith.array() -= zenith.mean();
  const double spread = std::sqrt(zenith.squaredNorm() / static_cast<double>(size));
  const bool with_zenith = size >= 8 && spread > 0.2 * kPi / 180.0;
  Eigen::MatrixXd basis(size, with_zenith ? 4 : 3);
  basis.col(0).setOnes();
  basis.col(1) = azimuth;
  basis.col(2) = azimuth.cwiseAbs2();
  if (with_zenith) basis.col(3) = zenith / spread;

  // Tukey's weights, one per column for its three channels, from least absolute deviations onwards.
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(size);
  Eigen::MatrixXd residual;
  double scale = 0.0;
  for (int round = 0; round < 30; ++round) {
    const Eigen::VectorXd root = weight.cwiseSqrt();
    const Eigen::MatrixXd coefficients =
        (root.asDiagonal() * basis).colPivHouseholderQr().solve(root.asDiagonal() * log_light);
    residual = log_light - basis * coefficients;
    const Eigen::VectorXd size_of = residual.rowwise().norm();
    scale = std::max(robust_sigma(std::vector(size_of.data(), size_of.data() + size)), 1e-3);
    for (Eigen::Index i = 0; i < size; ++i) {
      weight[i] =
          round < 10 ? 1.0 / std::max(size_of[i], scale) : tukey_weight(size_of[i] / (kTukeyReach * scale)) + 1e-9;
    }
  }
  const Eigen::MatrixXd fitted = log_light - residual;
  const auto agrees = [&](Eigen::Index i) { return residual.row(i).norm() < 3.0 * scale; };
  for (Eigen::Index i = 0; i < size; ++i) {
    HorizonColumn& column = columns[static_cast<std::size_t>(i)];
    Eigen::RowVector3d kept = Eigen::RowVector3d::Zero();
    if (agrees(i)) {
      double total = 0.0;
      for (Eigen::Index j = std::max<Eigen::Index>(0, i - 1); j <= std::min(size - 1, i + 1); ++j) {
        if (!agrees(j)) continue;
        const double share = i == j ? 2.0 : 1.0;
        kept += share * residual.row(j);
        total += share;
      }
      kept /= total;
    } else {
      column.quality *= 0.3;
    }
    for (int c = 0; c < 3; ++c) column.light[c] = std::exp(fitted(i, c) + kept[c]);
  }
}

}  // namespace

SmoothHorizon lowest_sky(const HorizonPixels& scene, const std::vector<HorizonStrip>& strips) {
  SmoothHorizon lowest;
  int clipped = 0;
  for (const HorizonStrip& strip : strips) {
    if (const auto measured = measure_strip(scene, strip)) {
      lowest.columns.push_back(measured->column);
      clipped += measured->clipped ? 1 : 0;
    }
  }
  lowest.clipped = 2 * clipped > static_cast<int>(lowest.columns.size());
  smooth_over_azimuth(lowest.columns);
  return lowest;
}

}  // namespace kasumi
