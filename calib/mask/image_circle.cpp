#include "calib/mask/image_circle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "calib/mask/rim_scan.hpp"

namespace kasumi {
namespace {

constexpr int kWorkingSize_px = 640;  // larger pictures are shrunk first: an accuracy of 1 % will do
constexpr int kRays = RimScan::kRays;
constexpr int kSectors = 24;

double tolerance_px(double radius_px) {
  return std::max(1.0, 0.006 * radius_px);
}

// Within which light falls from its level inside to that outside.
double reach_px(const ImageCircle& circle) {
  return std::max(4.0, 0.025 * circle.radius_px);
}

// Mostly green, which purple fringes leave alone; without hot pixels.
cv::Mat1b brightness(const Image<Rgb8>& picture) {
  cv::Mat1b bright(picture.height(), picture.width());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& rgb = picture.at(x, y);
      bright(y, x) = static_cast<std::uint8_t>((rgb.r + 4 * rgb.g + rgb.b + 3) / 6);
    }
  cv::medianBlur(bright, bright, 3);
  return bright;
}

glm::dvec2 middle_of_light(const cv::Mat1b& brightness) {
  cv::Mat lit;
  cv::threshold(brightness, lit, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  const auto moments = cv::moments(lit, true);
  if (moments.m00 <= 0.0) return {0.5 * brightness.cols, 0.5 * brightness.rows};
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

std::optional<ImageCircle> circle_through(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const auto ab = b - a, ac = c - a;
  const double twice_area = ab.x * ac.y - ab.y * ac.x;
  if (std::abs(twice_area) < 1.0) return std::nullopt;
  const double ab2 = glm::dot(ab, ab), ac2 = glm::dot(ac, ac);
  const glm::dvec2 to_centre = glm::dvec2{ac.y * ab2 - ab.y * ac2, ab.x * ac2 - ac.x * ab2} / (2.0 * twice_area);
  return ImageCircle{a + to_centre, glm::length(to_centre)};
}

// Rays with an edge on the circle count for it. Light that ends only further out counts against it: it would lie
// outside. What is dark inside hides the rim and says nothing.
double support_of(const ImageCircle& circle, const std::vector<RayEdges>& rays, int every) {
  const double tolerance = tolerance_px(circle.radius_px);
  double support = 0.0;
  for (std::size_t i = 0; i < rays.size(); i += static_cast<std::size_t>(every)) {
    bool on = false, beyond = false;
    for (const RimEdge& edge : rays[i]) {
      const double off = glm::distance(edge.point, circle.centre) - circle.radius_px;
      if (std::abs(off) <= tolerance)
        on = true;
      else if (off > tolerance)
        beyond = true;
    }
    support += (on ? 1.0 : 0.0) - (beyond ? 0.6 : 0.0);
  }
  return support * every;
}

// RANSAC, on edges of rays that are far apart.
std::optional<ImageCircle> best_circle(const std::vector<RayEdges>& rays, const RimScan& scan) {
  constexpr int kTrials = 3000;
  const double shorter = std::min(scan.width(), scan.height()), longer = std::max(scan.width(), scan.height());
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (!rays[i].empty()) seen.push_back(i);
  if (seen.size() < kRays / 12) return std::nullopt;
  std::mt19937_64 random(1);
  const auto any_edge = [&]() -> const RimEdge& {
    const RayEdges& ray = rays[seen[random() % seen.size()]];
    // The outermost edge more often than others.
    return random() % 2 == 0 ? ray.back() : ray[random() % ray.size()];
  };
  std::optional<ImageCircle> best;
  double best_support = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const glm::dvec2 a = any_edge().point, b = any_edge().point, c = any_edge().point;
    const auto circle = circle_through(a, b, c);
    if (!circle || circle->radius_px < 0.15 * shorter || circle->radius_px > 1.2 * longer) continue;
    if (!scan.contains(circle->centre, -0.2 * shorter)) continue;
    if (support_of(*circle, rays, 8) < 0.8 * best_support) continue;
    const double support = support_of(*circle, rays, 2);
    if (support > best_support) {
      best_support = support;
      best = circle;
    }
  }
  return best;
}

// Least squares on distances from the centre, with Tukey's weights; what it leaves.
struct RimFit {
  ImageCircle circle;
  double scatter_px = 0.0;
  double rays = 0.0;  // that agree
};
std::optional<RimFit> fit_to(const std::vector<glm::dvec2>& points, const ImageCircle& start, double window_px) {
  if (points.size() < kRays / 24) return std::nullopt;
  RimFit fit{start, 0.0, 0.0};
  Eigen::Matrix3d normal;
  for (int round = 0; round < 12; ++round) {
    normal.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double weights = 0.0, squares = 0.0;
    for (const auto& point : points) {
      const auto offset = point - fit.circle.centre;
      const double distance = glm::length(offset), left = distance - fit.circle.radius_px;
      const double u = std::max(0.0, 1.0 - (left / window_px) * (left / window_px)), w = u * u;
      const Eigen::Vector3d slope{offset.x / distance, offset.y / distance, 1.0};
      normal += w * slope * slope.transpose();
      right += w * left * slope;
      weights += w;
      squares += w * left * left;
    }
    if (weights < kRays / 30.0) return std::nullopt;
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    fit.circle.centre += glm::dvec2{step.x(), step.y()};
    fit.circle.radius_px += step.z();
    fit.scatter_px = std::sqrt(squares / weights);
    fit.rays = weights;
  }
  // Neighbouring rays share their errors.
  constexpr double kSharing = 12.0;
  const Eigen::Matrix3d covariance = normal.inverse() * std::pow(std::max(fit.scatter_px, 0.1), 2) * kSharing;
  fit.circle.sigma_px = std::sqrt(covariance.diagonal().maxCoeff());
  return fit;
}

std::vector<glm::dvec2> edges_near(const ImageCircle& circle, const std::vector<RayEdges>& rays, double window_px) {
  std::vector<glm::dvec2> points;
  for (const RayEdges& ray : rays)
    for (const RimEdge& edge : ray)
      if (std::abs(glm::distance(edge.point, circle.centre) - circle.radius_px) < window_px)
        points.push_back(edge.point);
  return points;
}

// The rim is where light falls through the middle of its step, however soft that is.
std::vector<glm::dvec2> crossings(const RimScan& scan, const ImageCircle& circle) {
  std::vector<glm::dvec2> points;
  for (int ray = 0; ray < kRays; ++ray) {
    const double r = scan.crossing_px(circle.centre, ray, circle.radius_px, reach_px(circle));
    if (std::isfinite(r)) points.push_back(circle.centre + r * RimScan::direction(ray));
  }
  return points;
}

std::optional<RimFit> fit_to_crossings(const RimScan& scan, const ImageCircle& start) {
  std::optional<RimFit> fit = RimFit{start};
  for (const double window : {6.0, 3.0, 2.0})
    if (fit) fit = fit_to(crossings(scan, fit->circle), fit->circle, window * tolerance_px(fit->circle.radius_px));
  return fit;
}

// Radius of the concentric circle beyond this one at which most rays grow darker in a step, or 0. Each ray's step may
// drown in noise.
double outer_step_px(const RimScan& scan, const ImageCircle& circle) {
  constexpr int kEvery = 3, kFewest = 24;
  const double reach = reach_px(circle);
  const auto step_at = [&](double radius) {
    std::vector<float> steps;
    for (int ray = 0; ray < kRays; ray += kEvery) {
      const glm::dvec2 ahead = RimScan::direction(ray);
      if (!scan.contains(circle.centre + (radius + 5.0) * ahead, 1.0)) continue;
      double step = 0.0;
      for (int k = 2; k <= 4; ++k)
        step += scan.log_at(circle.centre + (radius - k) * ahead) - scan.log_at(circle.centre + (radius + k) * ahead);
      steps.push_back(static_cast<float>(step / 3.0));
    }
    return steps;
  };
  double best = 0.0, best_radius = 0.0;
  std::vector<double> middles, errors;
  for (double radius = circle.radius_px + 1.5 * reach; radius < 1.35 * circle.radius_px; radius += 1.0) {
    auto steps = step_at(radius);
    if (steps.size() < kFewest) break;
    const auto count = static_cast<double>(steps.size());
    const double middle = static_cast<double>(median_in_place(steps));
    for (float& step : steps) step = std::abs(step - static_cast<float>(middle));
    const double error =
        1.25 * kSigmaOverMedianSize * static_cast<double>(median_in_place(steps)) / std::sqrt(0.5 * count);
    middles.push_back(middle);
    errors.push_back(error);
  }
  for (std::size_t i = 8; i + 8 < middles.size(); ++i) {
    const double rise = middles[i] - 0.5 * (middles[i - 8] + middles[i + 8]);
    if (middles[i] < 0.03 || rise < 6.0 * errors[i] || rise < 0.6 * middles[i] || rise < best) continue;
    best = rise;
    best_radius = circle.radius_px + 1.5 * reach + static_cast<double>(i);
  }
  return best_radius;
}

// What speaks for a circle when all is said.
struct RimEvidence {
  int inside_frame = 0;       // rays whose rim lies inside it
  int on = 0;                 // of them with an edge on the rim
  int beyond = 0;             // with an edge further out
  int sectors = 0;            // of kSectors, with half of its rays on
  double roughness_px = 0.0;  // from ray to ray: a skyline's is larger than a rim's
};
RimEvidence evidence_for(const RimScan& scan, const ImageCircle& circle) {
  RimEvidence evidence;
  const auto rays = scan.edges(circle.centre);
  const double tolerance = tolerance_px(circle.radius_px), reach = reach_px(circle);
  std::vector<int> on_in_sector(kSectors, 0);
  std::vector<float> jumps;
  double before = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kRays; ++i) {
    const glm::dvec2 ahead = RimScan::direction(i);
    if (!scan.contains(circle.centre + (circle.radius_px + 2.0 * reach) * ahead, 1.0)) continue;
    ++evidence.inside_frame;
    const double crossing = scan.crossing_px(circle.centre, i, circle.radius_px, reach);
    if (i % 3 == 0) {
      if (std::isfinite(crossing - before)) jumps.push_back(static_cast<float>(std::abs(crossing - before)));
      before = crossing;
    }
    const bool on = std::abs(crossing - circle.radius_px) <= tolerance;
    bool beyond = false;
    for (const RimEdge& edge : rays[static_cast<std::size_t>(i)])
      beyond = beyond || glm::distance(edge.point, circle.centre) - circle.radius_px > 2.0 * reach;
    evidence.on += on ? 1 : 0;
    evidence.beyond += beyond ? 1 : 0;
    on_in_sector[static_cast<std::size_t>(i * kSectors / kRays)] += on ? 1 : 0;
  }
  if (!jumps.empty()) evidence.roughness_px = static_cast<double>(median_in_place(jumps));
  for (const int on : on_in_sector) evidence.sectors += on >= kRays / kSectors / 2 ? 1 : 0;
  return evidence;
}

// Nearly half of the rim that the frame shows must be seen, in several places. It is round, or, behind a dome or before
// mountains, nearly round but smooth; a skyline is neither.
bool convincing(const RimEvidence& evidence, const RimFit& fit) {
  const double radius = fit.circle.radius_px;
  const auto at_most = [&](double px, double of_radius) { return std::max(px, of_radius * radius); };
  const bool is_round = fit.scatter_px < at_most(0.45, 0.003);
  const bool is_smooth = fit.scatter_px < at_most(0.7, 0.005) && evidence.roughness_px < at_most(0.2, 0.001);
  return evidence.on >= 0.45 * evidence.inside_frame && evidence.sectors >= 4 &&
         evidence.beyond <= 0.15 * evidence.inside_frame && (is_round || is_smooth) &&
         fit.circle.sigma_px < 0.004 * radius;
}

}  // namespace

std::optional<ImageCircle> find_image_circle(const Image<Rgb8>& picture) {
  if (picture.width() < 16 || picture.height() < 16) return std::nullopt;
  cv::Mat1b bright = brightness(picture);
  const double longer = std::max(bright.cols, bright.rows);
  const double shrink = std::max(1.0, longer / kWorkingSize_px);
  if (shrink > 1.0) cv::resize(bright, bright, {}, 1.0 / shrink, 1.0 / shrink, cv::INTER_AREA);
  const RimScan scan(bright);

  auto rays = scan.edges(middle_of_light(bright));
  auto circle = best_circle(rays, scan);
  if (!circle) return std::nullopt;
  if (scan.contains(circle->centre, 2.0)) {  // rays from the middle meet the rim at right angles
    rays = scan.edges(circle->centre);
    if (const auto again = best_circle(rays, scan)) circle = again;
  }
  auto fit = fit_to(edges_near(*circle, rays, 3.0 * tolerance_px(circle->radius_px)), *circle,
                    3.0 * tolerance_px(circle->radius_px));
  if (fit) fit = fit_to_crossings(scan, fit->circle);
  if (!fit) return std::nullopt;
  // A skyline may be as round as the rim, which then is a faint step further out.
  if (const double outer = outer_step_px(scan, fit->circle); outer > 0.0)
    fit = fit_to_crossings(scan, {fit->circle.centre, outer});
  if (!fit || !scan.contains(fit->circle.centre, -0.2 * longer) || !convincing(evidence_for(scan, fit->circle), *fit))
    return std::nullopt;
  const glm::dvec2 half{0.5};
  return ImageCircle{shrink * (fit->circle.centre + half) - half, shrink * fit->circle.radius_px,
                     shrink * fit->circle.sigma_px};
}

}  // namespace kasumi
