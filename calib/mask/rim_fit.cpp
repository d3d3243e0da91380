#include "calib/mask/rim_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr double kAlong = 0.93;  // cosine between an edge's normal and the radius: 20 degrees
constexpr int kFewestSectors = 10;

}  // namespace

glm::dvec2 Rim::point_at(const glm::dvec2& direction, double radius_share) const {
  const auto stretched = centre + radius * radius_share * direction;
  return {stretched.x / aspect, stretched.y};
}
double Rim::off(const glm::dvec2& point) const {
  return glm::length(glm::dvec2{point.x * aspect, point.y} - centre) - radius;
}
int sector_of(const Rim& rim, const glm::dvec2& point) {
  const float turn_deg = cv::fastAtan2(static_cast<float>(point.y - rim.centre.y),
                                       static_cast<float>(point.x * rim.aspect - rim.centre.x));
  return static_cast<int>(turn_deg * (kRimSectors / 360.0f)) % kRimSectors;
}

std::vector<RimEdge> edges_along(const std::vector<RimEdge>& edges, const Rim& rim, double window) {
  std::vector<RimEdge> along;
  const double inner = std::max(0.0, rim.radius - window), outer = rim.radius + window;
  for (const RimEdge& edge : edges) {
    const glm::dvec2 stretch{rim.aspect, 1.0}, from = stretch * glm::dvec2(edge.point) - rim.centre;
    const double square = glm::dot(from, from);
    if (square < inner * inner || square > outer * outer) continue;
    const glm::dvec2 normal = glm::dvec2(edge.normal) / stretch;
    const double across = glm::dot(normal, from);
    if (across * across > kAlong * kAlong * square * glm::dot(normal, normal)) along.push_back(edge);
  }
  return along;
}

std::optional<Rim> fit_rim(const std::vector<RimEdge>& edges, const Rim& start, double window, bool with_aspect) {
  constexpr int kRounds = 4;
  const auto near = edges_along(edges, start, 1.5 * window);
  std::vector<std::size_t> sectors(near.size());
  std::array<double, static_cast<std::size_t>(kRimSectors)> in_sector{};
  for (std::size_t i = 0; i < near.size(); ++i) {
    sectors[i] = static_cast<std::size_t>(sector_of(start, near[i].point));
    if (std::abs(start.off(near[i].point)) < window) in_sector[sectors[i]] += static_cast<double>(near[i].strength);
  }
  if (std::ranges::count_if(in_sector, [](double s) { return s > 0.0; }) < kFewestSectors) return std::nullopt;
  Rim rim = start;
  const int size = with_aspect ? 4 : 3;
  Eigen::Matrix4d normal;
  double squares = 0.0, weights = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    normal.setZero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    squares = weights = 0.0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      const glm::dvec2 point(near[i].point), from = glm::dvec2{point.x * rim.aspect, point.y} - rim.centre;
      const double distance = glm::length(from), left = distance - rim.radius;
      const double share = static_cast<double>(near[i].strength) / std::max(0.3, in_sector[sectors[i]]);
      const double w = tukey_weight(left / window) * share;
      if (w <= 0.0) continue;
      const Eigen::Vector4d slope{from.x / distance, from.y / distance, 1.0,
                                  with_aspect ? -from.x / distance * point.x : 0.0};
      const Eigen::Vector4d weighted = w * slope;
      normal.noalias() += weighted * slope.transpose();
      right += left * weighted;
      weights += w;
      squares += w * left * left;
    }
    normal += 1e-3 * Eigen::Matrix4d::Identity();  // an arc alone says little of the centre across it
    const Eigen::VectorXd step = normal.topLeftCorner(size, size).ldlt().solve(right.head(size));
    if (!step.allFinite() || step.head(3).norm() > 0.3 * start.radius) return std::nullopt;
    rim.centre += glm::dvec2{step[0], step[1]};
    rim.radius += step[2];
    if (with_aspect) rim.aspect = std::clamp(rim.aspect + step[3], 0.8, 1.25);
  }
  // Neighbouring sectors share their errors.
  constexpr double kSharing = 4.0;
  const double variance = kSharing * std::max(0.01, squares / std::max(1.0, weights));
  const Eigen::MatrixXd covariance = normal.topLeftCorner(size, size).inverse() * variance;
  rim.sigma = std::sqrt(std::max(0.0, covariance.diagonal().head(3).maxCoeff()));
  rim.aspect_sigma = with_aspect ? std::sqrt(std::max(0.0, covariance(3, 3))) : 0.0;
  return rim;
}

}  // namespace kasumi
