// The lowest visible sky of the scene camera, column by column.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "estimator/horizon.hpp"

namespace kasumi {
namespace {

constexpr double kBandShare = 0.025;    // of the picture's height: the horizon region
constexpr double kMarginShare = 0.006;  // above the silhouette, whose pixels are mixed
constexpr double kSearchShare = 0.15;   // of the picture's height above the segmentation's edge, where a faded hill may
constexpr double kSearchDegrees = 3.0;  // hide; and at least so far up: a telephoto view is filled by such hills
constexpr int kClipped = 252;           // encoded
constexpr double kSoftestHill = 0.02;   // relative drop of light that counts as a hill's edge: 1.5 steps of 8 bits

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Pixel {
  int x = 0, y = 0;
  glm::dvec3 light{0};
  double brightness = 0.0;
  bool clipped = false;
};

struct Scene {
  const Camera& camera;
  const Image<Rgb8>& picture;
  const Image<std::uint8_t>& sky;

  Pixel pixel(int x, int y) const {
    const Rgb8& encoded = picture.at(x, y);
    const glm::dvec3 light = camera.light_at({x, y}, glm::dvec3(encoded) / 255.0);
    return {x, y, light, (light.x + light.y + light.z) / 3.0,
            encoded.x >= kClipped || encoded.y >= kClipped || encoded.z >= kClipped};
  }
};

// Pixels below the horizon by more than half a degree are never sky; every 8th pixel decides for its block.
Image<std::uint8_t> below_horizon(const Camera& camera) {
  constexpr int kBlock = 8;
  constexpr double kBelow = 0.5 * kPi / 180.0;
  Image<std::uint8_t> mask(camera.width, camera.height);
  for (int y0 = 0; y0 < camera.height; y0 += kBlock) {
    for (int x0 = 0; x0 < camera.width; x0 += kBlock) {
      const int x1 = std::min(x0 + kBlock, camera.width), y1 = std::min(y0 + kBlock, camera.height);
      const auto direction = camera.direction_at({0.5 * (x0 + x1 - 1), 0.5 * (y0 + y1 - 1)});
      if (direction && zenith_angle(*direction).value <= kPi / 2.0 + kBelow) continue;
      for (int y = y0; y < y1; ++y) std::fill(mask.row(y) + x0, mask.row(y) + x1, std::uint8_t{255});
    }
  }
  return mask;
}

// Lowest row at which the strip x0..x1 is mostly sky; -1 when nowhere.
int sky_bottom(const Scene& scene, int x0, int x1) {
  for (int y = scene.picture.height() - 1; y >= 0; --y) {
    int count = 0;
    for (int x = x0; x < x1; ++x) count += scene.sky.at(x, y) != 0 ? 1 : 0;
    if (2 * count > x1 - x0) return y;
  }
  return -1;
}

// Median over the strip's sky pixels of a row. Red on its own, too, because the air lets most of it through: a hill
// that has all but faded shows there last.
enum class Seen { brightness, red };
double row_light(const Scene& scene, int x0, int x1, int y, Seen seen) {
  std::vector<double> values;
  const int step = std::max(1, (x1 - x0) / 48);
  for (int x = x0; x < x1; x += step) {
    if (scene.sky.at(x, y) == 0) continue;
    const Pixel pixel = scene.pixel(x, y);
    values.push_back(seen == Seen::red ? pixel.light.x : pixel.brightness);
  }
  return median(std::move(values));
}

// First index of a step down in a profile, seen through means of `reach` values; -1 when there is none. A silhouette's
// light changes little right above and right below its edge and does not come back soon; a cloud's does one or the
// other.
int first_step_down(const std::vector<double>& profile, int reach, double noise) {
  const auto mean = [&](int first) {
    double sum = 0.0;
    for (int i = 0; i < reach; ++i) sum += profile[static_cast<std::size_t>(first + i)];
    return sum / reach;
  };
  const int size = static_cast<int>(profile.size());
  for (int i = 2 * reach; i + 2 * reach <= size; ++i) {
    const double above = mean(i - reach), below = mean(i), drop = above - below;
    const double beside = std::max(std::abs(mean(i - 2 * reach) - above), std::abs(below - mean(i + reach)));
    if (drop < kSoftestHill * above || drop < 4.0 * noise || drop < 2.5 * beside) continue;
    const auto first_below = profile.begin() + i + reach / 2;
    const double brightest_below = *std::max_element(first_below, profile.begin() + std::min(size, i + 4 * reach));
    if (brightest_below < above - 0.5 * drop) return i - reach / 2 - 1;
  }
  return -1;
}

// Rows that kSearchDegrees make above a row.
int rows_of(const Camera& camera, int row) {
  const double x = 0.5 * (camera.width - 1);
  const auto here = camera.direction_at({x, row}), above = camera.direction_at({x, row - 8.0});
  if (!here || !above) return 0;
  const double degrees_per_row = to_degrees(angle_between(*here, *above)) / 8.0;
  return static_cast<int>(kSearchDegrees / std::max(degrees_per_row, 1e-6));
}

// The row above the silhouette of a hill that has faded into the sky, near `bottom`; `bottom` itself when there is
// none.
int above_faded_hills(const Scene& scene, int x0, int x1, int bottom) {
  const int height = scene.picture.height();
  const int top =
      std::max(0, bottom - std::max(static_cast<int>(kSearchShare * height), rows_of(scene.camera, bottom)));
  int highest = bottom;
  for (const Seen seen : {Seen::brightness, Seen::red}) {
    std::vector<double> profile;  // from the top down
    for (int y = top; y <= bottom; ++y) profile.push_back(row_light(scene, x0, x1, y, seen));
    std::vector<double> changes;
    for (std::size_t i = 1; i < profile.size(); ++i) changes.push_back(std::abs(profile[i] - profile[i - 1]));
    const double noise = 1.4826 * median(changes);
    // Sharp edges and, in fog, soft ones.
    for (const int reach : {std::max(3, height / 150), std::max(5, height / 75), std::max(8, height / 40)}) {
      if (const int step = first_step_down(profile, reach, noise); step >= 0) highest = std::min(highest, top + step);
    }
  }
  return highest;
}

struct Measured {
  HorizonColumn column;
  bool clipped = false;
};

std::optional<Measured> measure_strip(const Scene& scene, int x0, int x1) {
  const int height = scene.picture.height();
  const int edge = sky_bottom(scene, x0, x1);
  if (edge < 0) return std::nullopt;
  const int bottom = above_faded_hills(scene, x0, x1, edge) - std::max(1, static_cast<int>(kMarginShare * height));
  const int top = bottom - std::max(4, static_cast<int>(kBandShare * height));
  if (top < 0) return std::nullopt;

  std::vector<Pixel> pixels;
  const int step = std::max(1, (x1 - x0) / 64);
  for (int y = top; y < bottom; ++y) {
    for (int x = x0; x < x1; x += step) {
      if (scene.sky.at(x, y) != 0) pixels.push_back(scene.pixel(x, y));
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
  const double tolerance = std::max(3.0 * 1.4826 * median(brightness), 0.01 * centre);

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

// Logarithm of light as a quadratic in azimuth, plus a slope in zenith angle where the columns see different ones
// (silhouettes). Columns that disagree get the fit, the others keep a smoothed part of what they saw.
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
    scale = std::max(1.4826 * median({size_of.data(), size_of.data() + size}), 1e-3);
    for (Eigen::Index i = 0; i < size; ++i) {
      const double u = size_of[i] / (4.685 * scale);
      weight[i] = round < 10 ? 1.0 / std::max(size_of[i], scale) : std::pow(std::max(0.0, 1.0 - u * u), 2) + 1e-9;
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

HorizonLight measure_horizon(const Camera& scene, const PictureView& picture, int columns) {
  HorizonLight horizon;
  if (picture.width != scene.width || picture.height != scene.height) {
    horizon.reason = fmt::format("picture is {}x{}, the scene camera {}x{}", picture.width, picture.height, scene.width,
                                 scene.height);
    return horizon;
  }
  const Image<Rgb8> rgb = to_rgb(picture);
  const SkySegmentation segmentation = segment_sky(rgb, below_horizon(scene));
  if (!segmentation.visible) {
    horizon.reason = segmentation.reason;
    return horizon;
  }
  const Scene view{scene, rgb, segmentation.sky};
  const int strips = std::clamp(columns, 1, std::max(1, scene.width / 8));
  int clipped = 0;
  for (int i = 0; i < strips; ++i) {
    if (const auto measured = measure_strip(view, i * scene.width / strips, (i + 1) * scene.width / strips)) {
      horizon.columns.push_back(measured->column);
      clipped += measured->clipped ? 1 : 0;
    }
  }
  const int found = static_cast<int>(horizon.columns.size());
  if (4 * found < strips) {
    horizon.reason = fmt::format("no horizon: sky in {} of {} columns, less than a quarter", found, strips);
    horizon.columns.clear();
    return horizon;
  }
  smooth_over_azimuth(horizon.columns);
  horizon.source = HorizonLight::Source::scene_camera;
  if (2 * clipped > found) horizon.reason = "the horizon sky is clipped: its light is at least this";
  return horizon;
}

}  // namespace kasumi
