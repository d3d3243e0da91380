#include "calib/mask/rim_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"

namespace kasumi {

namespace {

constexpr double kSmallestContrast = 0.12;
constexpr int kSide = 4;  // samples on each side of an edge
constexpr std::size_t kEdgesOfRay = 4;

float bilinear(const cv::Mat1f& image, const glm::dvec2& point) {
  const double x = std::clamp(point.x, 0.0, image.cols - 1.001), y = std::clamp(point.y, 0.0, image.rows - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const auto u = static_cast<float>(x - i), v = static_cast<float>(y - j);
  return (image(j, i) * (1.0f - u) + image(j, i + 1) * u) * (1.0f - v) +
         (image(j + 1, i) * (1.0f - u) + image(j + 1, i + 1) * u) * v;
}

// Scatter from pixel to pixel in the darker half of the picture.
double dark_noise(const cv::Mat1b& brightness) {
  std::vector<float> levels, differences;
  for (int y = 0; y < brightness.rows; y += 2)
    for (int x = 0; x < brightness.cols; x += 2) levels.push_back(static_cast<float>(brightness(y, x)));
  const auto middle = static_cast<float>(quantile(levels, 0.4));
  for (int y = 1; y < brightness.rows; y += 2)
    for (int x = 1; x + 1 < brightness.cols; x += 2)
      if (static_cast<float>(brightness(y, x)) <= middle)
        differences.push_back(std::abs(static_cast<float>(brightness(y, x)) -
                                       0.5f * static_cast<float>(brightness(y, x - 1) + brightness(y, x + 1))));
  return differences.empty()
             ? 0.0
             : static_cast<double>(kSigmaOverMedianSize) * static_cast<double>(median_in_place(differences));
}

// Scatter of steps where the picture is dark.
double step_noise(const cv::Mat1f& log_light) {
  std::vector<float> levels, steps;
  for (int y = 0; y < log_light.rows; y += 3)
    for (int x = 0; x < log_light.cols; x += 3) levels.push_back(log_light(y, x));
  const auto middle = static_cast<float>(quantile(levels, 0.4));
  for (int y = 0; y < log_light.rows; y += 3)
    for (int x = kSide; x + kSide < log_light.cols; x += 3) {
      if (log_light(y, x) > middle) continue;
      float step = 0.0f;
      for (int k = 1; k <= kSide; ++k) step += log_light(y, x - k) - log_light(y, x + k);
      steps.push_back(std::abs(step) / kSide);
    }
  return steps.empty() ? 0.0 : static_cast<double>(kSigmaOverMedianSize) * static_cast<double>(median_in_place(steps));
}

}  // namespace

RimScan::RimScan(const cv::Mat1b& brightness) {
  const double floor = 6.0 + 2.0 * dark_noise(brightness);
  cv::Mat1f smooth;
  brightness.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, 0.8);
  cv::log(smooth + floor, log_);
  least_contrast_ = std::max(kSmallestContrast, 5.0 * step_noise(log_));
  cv::multiply(smooth, smooth, light_);  // about linear
}

glm::dvec2 RimScan::direction(int ray) {
  const double turn = 2.0 * kPi * ray / kRays;
  return {std::cos(turn), std::sin(turn)};
}
double RimScan::log_at(const glm::dvec2& point) const {
  return static_cast<double>(bilinear(log_, point));
}
bool RimScan::contains(const glm::dvec2& point, double margin) const {
  return point.x >= margin && point.y >= margin && point.x <= log_.cols - 1 - margin &&
         point.y <= log_.rows - 1 - margin;
}

std::vector<RayEdges> RimScan::edges(const glm::dvec2& from) const {
  std::vector<RayEdges> all(kRays);
  std::vector<double> profile, steps;
  for (int ray = 0; ray < kRays; ++ray) {
    const glm::dvec2 ahead = direction(ray);
    profile.clear();
    for (double r = 0.0; contains(from + r * ahead, 1.0); r += 1.0) profile.push_back(log_at(from + r * ahead));
    const int n = static_cast<int>(profile.size());
    steps.assign(profile.size(), 0.0);
    const auto at = [&](int i) { return profile[static_cast<std::size_t>(i)]; };
    for (int i = kSide; i + kSide < n; ++i) {
      double inside = 0.0, outside = 0.0;
      for (int k = 1; k <= kSide; ++k) {
        inside += at(i - k);
        outside += at(i + k);
      }
      steps[static_cast<std::size_t>(i)] = (inside - outside) / kSide;
    }
    RayEdges& edges = all[static_cast<std::size_t>(ray)];
    for (int i = kSide + 1; i + kSide + 1 < n; ++i) {
      const double here = steps[static_cast<std::size_t>(i)], before = steps[static_cast<std::size_t>(i - 1)],
                   after = steps[static_cast<std::size_t>(i + 1)];
      if (here < least_contrast_ || here < before || here <= after) continue;
      const double bend = before - 2.0 * here + after;
      const double shift = bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
      edges.push_back({from + (i + shift) * ahead, here});
    }
    if (edges.size() > kEdgesOfRay) {  // the outermost stays
      std::ranges::nth_element(edges.begin(), edges.begin() + kEdgesOfRay - 1, edges.end() - 1, std::ranges::greater{},
                               &RimEdge::contrast);
      edges[kEdgesOfRay - 1] = edges.back();
      edges.resize(kEdgesOfRay);
    }
  }
  return all;
}

double RimScan::crossing_px(const glm::dvec2& centre, int ray, double radius_px, double reach_px) const {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const glm::dvec2 ahead = direction(ray);
  if (!contains(centre + (radius_px + 2.0 * reach_px) * ahead, 1.0)) return nothing;
  const auto light = [&](double r) { return static_cast<double>(bilinear(light_, centre + r * ahead)); };
  double near = 0.0, far = 0.0, outside = 0.0;
  constexpr int kSamples = 5;
  for (int k = 0; k < kSamples; ++k) {
    const double share = static_cast<double>(k) / kSamples;
    near += light(radius_px - reach_px * (0.8 + 0.6 * share)) / kSamples;
    far += light(radius_px - reach_px * (1.6 + 0.6 * share)) / kSamples;
    outside += light(radius_px + reach_px * (1.0 + share)) / kSamples;
  }
  // Vignetting goes on towards the rim.
  const double inside = std::clamp(near - 1.1 * (far - near), 0.4 * near, 1.2 * near);
  if (inside <= 1.3 * outside + 1.0) return nothing;
  const double middle = 0.5 * (inside + outside);
  for (double r = radius_px + reach_px; r > radius_px - reach_px; r -= 0.5) {
    const double here = light(r), further_in = light(r - 0.5);
    if (here <= middle && further_in > middle) return r - 0.5 * (middle - here) / (further_in - here);
  }
  return nothing;
}

}  // namespace kasumi
