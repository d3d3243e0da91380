#include "estimator/landmarks/contrast.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vec2.hpp>

#include "base/saturation.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {
namespace {

constexpr double kTrimmed = 0.1;       // of the pixels at either end: birds, wires, hot pixels
constexpr double kIndependent = 0.25;  // of a box's pixels: demosaicing and JPEG correlate the noise

// Robust estimate of a box's light.
struct BoxLight {
  glm::dvec3 mean{0};      // linear
  glm::dvec3 variance{0};  // of the mean, from the pixels' noise
  glm::dvec3 fall{0};      // d light / d row: the sky's gradient
  glm::dvec2 middle{0};
  double clipped = 0.0;  // share of its pixels
};

bool inside(const LandmarkBox& box, const Camera& camera) {
  return box.x >= 0 && box.y >= 0 && box.width > 0 && box.height > 0 && box.x + box.width <= camera.width &&
         box.y + box.height <= camera.height;
}

double trimmed_mean(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  const auto cut = static_cast<std::size_t>(kTrimmed * static_cast<double>(values.size()));
  double sum = 0.0;
  for (std::size_t i = cut; i < values.size() - cut; ++i) sum += values[i];
  return sum / static_cast<double>(values.size() - 2 * cut);
}

BoxLight light_of(const Camera& camera, const Image<glm::vec3>& encoded, const LandmarkBox& box, double pixel_noise,
                  const std::optional<RidgeStrip>& ridge = {}) {
  BoxLight found;
  found.middle = {box.x + 0.5 * (box.width - 1), box.y + 0.5 * (box.height - 1)};
  double clipped = 0.0;
  std::array<std::vector<double>, 3> light;
  glm::dvec3 slope{0}, by_row{0};
  double rows = 0.0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      if (ridge && !ridge->contains(x, y)) continue;
      const glm::dvec3 value(encoded.at(x, y));
      const glm::dvec3 pixel = camera.light_at({x, y}, value);
      // light_at divides by vignetting and white balance; so does the noise.
      slope += camera.response.slope(value) / (camera.white_balance * camera.vignetting.at({x, y}));
      const double row = y - found.middle.y;
      by_row += row * pixel;
      rows += row * row;
      for (std::size_t c = 0; c < 3; ++c) light[c].push_back(pixel[static_cast<int>(c)]);
      if (std::max({value.r, value.g, value.b}) >= kSaturatedBox) clipped += 1.0;
    }
  const auto pixels = static_cast<double>(light[0].size());
  if (pixels == 0.0) return found;
  found.clipped = clipped / pixels;
  for (std::size_t c = 0; c < 3; ++c) found.mean[static_cast<int>(c)] = trimmed_mean(light[c]);
  const glm::dvec3 noise = pixel_noise * slope / pixels;
  found.variance = noise * noise / std::max(1.0, kIndependent * pixels);
  if (rows > 0.0) found.fall = by_row / rows;
  return found;
}

// The light from infinity next to one landmark.
struct LandmarkBackdrop {
  glm::dvec3 light{0}, sigma{0};
  std::string doubt;  // or, without light, the reason
};

LandmarkBackdrop sky_beside(const Camera& camera, const Image<glm::vec3>& encoded, const ContrastLandmark& landmark,
                            const glm::dvec2& place, const HorizonLight& horizon, const ContrastNoise& noise) {
  LandmarkBackdrop sky;
  if (landmark.sky) {
    if (!inside(*landmark.sky, camera)) return {{}, {}, "its sky is outside the picture"};
    const auto box = light_of(camera, encoded, *landmark.sky, noise.pixel);
    sky.light = box.mean;
    // Below the box the sky's gradient may or may not continue: both are equally likely.
    const auto lower = glm::abs(box.fall) * std::abs(place.y - box.middle.y);
    sky.sigma = glm::sqrt(box.variance + lower * lower);
    if (box.clipped > noise.clipped_share) {
      sky.sigma = glm::sqrt(sky.sigma * sky.sigma + noise.clipped_sky * noise.clipped_sky * sky.light * sky.light);
      sky.doubt = "the sky next to it is clipped";
    }
    return sky;
  }
  const auto direction = camera.direction_at(place);
  if (!direction || !horizon.usable())
    return {{}, {}, horizon.reason.empty() ? "no light from infinity is known" : horizon.reason};
  const auto azimuth = azimuth_angle(*direction);
  const auto column = column_at(horizon, azimuth);
  sky.light = column.light;
  // Uncertainty from one azimuth to its neighbours, and from the disagreement among the column's own pixels.
  constexpr double kHalfColumn = 0.02;  // rad
  const auto left = column_at(horizon, Radians{azimuth.value - kHalfColumn}).light;
  const auto right = column_at(horizon, Radians{azimuth.value + kHalfColumn}).light;
  const auto doubtful = 0.02 + 0.1 * (1.0 - column.quality);
  sky.sigma = 0.5 * glm::abs(left - right) + doubtful * column.light;
  return sky;
}

ContrastReading read_contrast(const Camera& camera, const Image<glm::vec3>& encoded, const ContrastLandmark& landmark,
                              const HorizonLight& horizon, const ContrastNoise& noise) {
  ContrastReading reading;
  const auto refuse = [&](std::string reason) {
    reading.reason = std::move(reason);
    return reading;
  };
  if (!inside(landmark.surface, camera)) return refuse("it is outside the picture");
  const auto surface = light_of(camera, encoded, landmark.surface, noise.pixel, landmark.ridge);
  if (surface.clipped > noise.clipped_share) return refuse("it is brighter than full scale");
  const auto sky = sky_beside(camera, encoded, landmark, surface.middle, horizon, noise);
  if (!(std::min({sky.light.r, sky.light.g, sky.light.b}) > 0.0)) return refuse(sky.doubt);
  const auto relative = surface.mean / sky.light;
  auto variance = surface.variance / (sky.light * sky.light) + noise.flare * noise.flare;
  const auto of_sky = sky.sigma / sky.light;
  if (landmark.against) {
    if (!inside(*landmark.against, camera)) return refuse("its background is outside the picture");
    const auto against = light_of(camera, encoded, *landmark.against, noise.pixel);
    if (against.clipped > noise.clipped_share) return refuse("its background is brighter than full scale");
    reading.contrast = against.mean / sky.light - relative;
    variance += against.variance / (sky.light * sky.light) + of_sky * of_sky * reading.contrast * reading.contrast;
  } else {
    reading.contrast = 1.0 - relative;
    variance += of_sky * of_sky * relative * relative;
  }
  reading.sigma = glm::sqrt(variance);
  reading.reason = sky.doubt;
  reading.usable = true;
  return reading;
}

// Of a line from left to right; beyond its ends nothing.
std::optional<double> height_of(const std::vector<glm::dvec2>& line, double x) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (x >= line[i].x && x <= line[i + 1].x && line[i + 1].x > line[i].x)
      return std::lerp(line[i].y, line[i + 1].y, (x - line[i].x) / (line[i + 1].x - line[i].x));
  return std::nullopt;
}

}  // namespace

bool RidgeStrip::contains(int x, int y) const {
  const auto top = height_of(line, x);
  return top && y > *top + 1.0 && y <= *top + 1.0 + height_px;
}

LandmarkBox RidgeStrip::bounds() const {
  const auto [highest, lowest] = std::ranges::minmax(line, {}, &glm::dvec2::y);
  const auto left = static_cast<int>(std::ceil(line.front().x)), right = static_cast<int>(std::floor(line.back().x));
  const auto top = static_cast<int>(std::floor(highest.y)) + 1;
  const auto bottom = static_cast<int>(std::floor(lowest.y + 1.0 + height_px));
  return {left, top, right - left + 1, bottom - top + 1};
}

std::vector<ContrastReading> read_contrasts(const Camera& camera, const Image<glm::vec3>& encoded,
                                            const std::vector<ContrastLandmark>& landmarks, const HorizonLight& horizon,
                                            const ContrastNoise& noise) {
  std::vector<ContrastReading> readings;
  readings.reserve(landmarks.size());
  for (const auto& landmark : landmarks) readings.push_back(read_contrast(camera, encoded, landmark, horizon, noise));
  return readings;
}

void mark_lit(const std::vector<ContrastLandmark>& landmarks, const Direction& sun,
              std::vector<ContrastReading>& readings) {
  constexpr double kGrazing = 0.03;  // of the sun's direction across the facade
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (!landmarks[i].faces || sun.z <= 0.0) continue;
    const double azimuth = landmarks[i].faces->value;
    if (sun.x * std::sin(azimuth) + sun.y * std::cos(azimuth) > kGrazing) readings[i].lit = true;
  }
}

void refuse_dark_skies(const std::vector<ContrastLandmark>& landmarks, std::vector<ContrastReading>& readings) {
  // A dark surface more than 10 % brighter than its sky shows a sky that is no light from infinity. Two such, and a
  // fifth of all, refuse the picture (physics 11): a single one may be a lamp or a window.
  constexpr double kBrighter = -0.1, kDark = 0.5, kMany = 0.2, kSeveral = 2.0;
  static const std::string kWhy = "the sky beside it is darker than it, and no light from infinity";
  double before_sky = 0.0, brighter = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const auto& landmark = landmarks[i];
    if (!readings[i].usable || landmark.against || landmark.contrast - 2.0 * landmark.contrast_sigma < kDark) continue;
    before_sky += 1.0;
    if (readings[i].contrast.g > kBrighter) continue;
    brighter += 1.0;
    readings[i] = {false, kWhy, {}, {}};
  }
  if (brighter < std::max(kSeveral, kMany * before_sky)) return;
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (readings[i].usable && !landmarks[i].against) readings[i] = {false, kWhy, {}, {}};
}

double infinity_sigma(const ContrastLandmark& landmark, int picture_width) {
  // Sigma of f, the contrast left when none of the surface's light is: right beside, at the horizon, and per picture's
  // width (physics 11).
  constexpr double kBeside = 0.01, kAtHorizon = 0.03, kAcross = 0.4;
  if (landmark.against || picture_width <= 0) return kBeside;
  if (!landmark.sky) return kAtHorizon;
  const auto apart = [](int a, int a_length, int b, int b_length) {
    return std::max({0, b - a - a_length, a - b - b_length});
  };
  const auto &surface = landmark.surface, &sky = *landmark.sky;
  const double gap = std::hypot(apart(surface.x, surface.width, sky.x, sky.width),
                                apart(surface.y, surface.height, sky.y, sky.height));
  return kBeside + kAcross * gap / picture_width;
}

double haze_path_m(const ContrastLandmark& landmark, double camera_altitude_m) {
  const auto path = optical_path(camera_altitude_m, camera_altitude_m + landmark.rise_m, landmark.distance_m);
  return path.mie_m * std::exp(camera_altitude_m / kMieScaleHeight_m);
}

}  // namespace kasumi
