#include "calib/mask/image_circle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr int kDirections = 720;
constexpr int kWorkingSize_px = 640;  // larger pictures are shrunk first: an accuracy of 1 % will do
// Thresholds between surround and picture, in 1/255; tried from the darkest.
constexpr std::array kThresholds{1, 2, 3, 5, 8, 12, 18, 27, 40, 60, 90, 130};

double tolerance_px(double radius_px) {
  return std::max(1.0, 0.012 * radius_px);
}

// The brightest channel, without hot pixels.
cv::Mat brightness(const Image<Rgb8>& picture) {
  cv::Mat brightest(picture.height(), picture.width(), CV_8UC1);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& rgb = picture.at(x, y);
      brightest.at<std::uint8_t>(y, x) = std::max({rgb.r, rgb.g, rgb.b});
    }
  cv::medianBlur(brightest, brightest, 3);
  return brightest;
}

// Where the picture is brighter than a threshold, without specks.
cv::Mat lit_area(const cv::Mat& brightness, int threshold) {
  cv::Mat lit = brightness >= threshold;
  cv::Mat labels, statistics, centroids;
  const int components = cv::connectedComponentsWithStats(lit, labels, statistics, centroids, 8, CV_32S);
  const double smallest = 5e-4 * brightness.rows * brightness.cols;
  std::vector<std::uint8_t> keep(static_cast<std::size_t>(components), 0);
  for (int i = 1; i < components; ++i) keep[i] = statistics.at<int>(i, cv::CC_STAT_AREA) >= smallest ? 255 : 0;
  for (int y = 0; y < lit.rows; ++y)
    for (int x = 0; x < lit.cols; ++x) lit.at<std::uint8_t>(y, x) = keep[labels.at<int>(y, x)];
  return lit;
}

bool lit_at(const cv::Mat& lit, const glm::dvec2& point) {
  const auto x = static_cast<int>(std::lround(point.x)), y = static_cast<int>(std::lround(point.y));
  return x >= 0 && y >= 0 && x < lit.cols && y < lit.rows && lit.at<std::uint8_t>(y, x) != 0;
}

bool on_frame(const cv::Mat& lit, const glm::dvec2& point, double margin) {
  return point.x < margin || point.y < margin || point.x > lit.cols - 1 - margin || point.y > lit.rows - 1 - margin;
}

// How far a point inside the picture is from its frame along a direction.
double way_to_frame(const cv::Mat& picture, const glm::dvec2& from, const glm::dvec2& direction) {
  const glm::dvec2 far{direction.x > 0.0 ? picture.cols - from.x : from.x + 1.0,
                       direction.y > 0.0 ? picture.rows - from.y : from.y + 1.0};
  return std::min(far.x / std::max(std::abs(direction.x), 1e-9), far.y / std::max(std::abs(direction.y), 1e-9));
}

// The outermost lit point in every direction from a point. Points on the picture's frame are left out: there the rim is
// cut off.
std::vector<glm::dvec2> outermost_lit(const cv::Mat& lit, const glm::dvec2& from) {
  std::vector<glm::dvec2> points;
  for (int i = 0; i < kDirections; ++i) {
    const double turn = 2.0 * kPi * i / kDirections;
    const glm::dvec2 direction{std::cos(turn), std::sin(turn)};
    double r = way_to_frame(lit, from, direction);
    while (r > 0.0 && !lit_at(lit, from + r * direction)) r -= 0.5;
    const auto point = from + (r + 0.25) * direction;
    if (r > 0.0 && !on_frame(lit, point, 1.5)) points.push_back(point);
  }
  return points;
}

std::optional<ImageCircle> circle_through(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const auto ab = b - a, ac = c - a;
  const double twice_area = ab.x * ac.y - ab.y * ac.x;
  if (std::abs(twice_area) < 1.0) return std::nullopt;
  const double ab2 = glm::dot(ab, ab), ac2 = glm::dot(ac, ac);
  const glm::dvec2 to_centre = glm::dvec2{ac.y * ab2 - ab.y * ac2, ab.x * ac2 - ac.x * ab2} / (2.0 * twice_area);
  return ImageCircle{a + to_centre, glm::length(to_centre)};
}

bool is_near(const ImageCircle& circle, const glm::dvec2& point) {
  return std::abs(glm::distance(point, circle.centre) - circle.radius_px) <= tolerance_px(circle.radius_px);
}
bool is_beyond(const ImageCircle& circle, const glm::dvec2& point) {
  return glm::distance(point, circle.centre) > circle.radius_px + tolerance_px(circle.radius_px);
}

// Least squares on the points near the circle, a few times over (Gauss-Newton on the distances).
ImageCircle refined(ImageCircle circle, const std::vector<glm::dvec2>& points) {
  for (int round = 0; round < 8; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const auto& point : points) {
      if (!is_near(circle, point)) continue;
      const auto offset = point - circle.centre;
      const double distance = glm::length(offset);
      const Eigen::Vector3d slope{offset.x / distance, offset.y / distance, 1.0};
      normal += slope * slope.transpose();
      right += slope * (distance - circle.radius_px);
    }
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) break;
    circle.centre += glm::dvec2{step.x(), step.y()};
    circle.radius_px += step.z();
  }
  return circle;
}

// RANSAC. Dark objects hide parts of the rim, so points inside the circle cost nothing. Light outside means that the
// circle is too small, and costs double.
std::optional<ImageCircle> fit_circle(const std::vector<glm::dvec2>& points, double smallest, double largest) {
  if (points.size() < kDirections / 8) return std::nullopt;
  std::mt19937_64 random(1);
  const auto any_point = [&] { return points[random() % points.size()]; };
  std::optional<ImageCircle> best;
  int best_score = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto a = any_point(), b = any_point(), c = any_point();
    const auto circle = circle_through(a, b, c);
    if (!circle || circle->radius_px < smallest || circle->radius_px > largest) continue;
    int score = 0;
    for (const auto& point : points) score += is_near(*circle, point) ? 1 : is_beyond(*circle, point) ? -2 : 0;
    if (score > best_score) {
      best_score = score;
      best = circle;
    }
  }
  if (!best) return std::nullopt;
  return refined(*best, points);
}

// A quarter of the rim is visible, little light lies outside, and the surround is in the picture.
bool is_convincing(const ImageCircle& circle, const cv::Mat& lit) {
  int shown = 0, beyond = 0;
  for (const auto& point : outermost_lit(lit, circle.centre)) {
    shown += is_near(circle, point) ? 1 : 0;
    beyond += is_beyond(circle, point) ? 1 : 0;
  }
  if (shown < kDirections / 4 || beyond > shown / 8) return false;

  int surround = 0, spilt = 0;
  const double outside = circle.radius_px + 2.0 * tolerance_px(circle.radius_px);
  for (int y = 0; y < lit.rows; y += 2)
    for (int x = 0; x < lit.cols; x += 2)
      if (glm::distance(glm::dvec2{x, y}, circle.centre) > outside) {
        ++surround;
        spilt += lit.at<std::uint8_t>(y, x) ? 1 : 0;
      }
  return spilt <= surround / 20;
}

std::optional<ImageCircle> circle_at_threshold(const cv::Mat& brightness, int threshold) {
  const cv::Mat lit = lit_area(brightness, threshold);
  const auto moments = cv::moments(lit, true);
  if (moments.m00 <= 0.0) return std::nullopt;
  const double shorter = std::min(lit.cols, lit.rows), longer = std::max(lit.cols, lit.rows);
  const double smallest = 0.15 * shorter, largest = longer;
  const glm::dvec2 middle{moments.m10 / moments.m00, moments.m01 / moments.m00};
  auto circle = fit_circle(outermost_lit(lit, middle), smallest, largest);
  if (circle) circle = fit_circle(outermost_lit(lit, circle->centre), smallest, largest);
  if (!circle || !is_convincing(*circle, lit)) return std::nullopt;
  return circle;
}

bool agree(const ImageCircle& a, const ImageCircle& b) {
  const double near = 0.01 * a.radius_px;
  return glm::distance(a.centre, b.centre) <= near && std::abs(a.radius_px - b.radius_px) <= near;
}

}  // namespace

std::optional<ImageCircle> find_image_circle(const Image<Rgb8>& picture) {
  if (picture.width() < 16 || picture.height() < 16) return std::nullopt;
  cv::Mat bright = brightness(picture);
  const double longer = std::max(bright.cols, bright.rows);
  const double shrink = std::max(1.0, longer / kWorkingSize_px);
  if (shrink > 1.0) cv::resize(bright, bright, {}, 1.0 / shrink, 1.0 / shrink, cv::INTER_AREA);

  // The first threshold that the next one confirms: a true edge stays in place, the outline of a halo shrinks.
  std::optional<ImageCircle> first, before;
  for (const int threshold : kThresholds) {
    const auto circle = circle_at_threshold(bright, threshold);
    if (circle && before && agree(*before, *circle)) {
      first = before;
      break;
    }
    if (circle && !first) first = circle;
    before = circle;
  }
  if (!first) return std::nullopt;
  const glm::dvec2 half{0.5};
  return ImageCircle{shrink * (first->centre + half) - half, shrink * first->radius_px};
}

}  // namespace kasumi
