#include "calib/light/edge_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <glm/common.hpp>

#include "base/statistics.hpp"
#include "calib/light/jpeg_block.hpp"

namespace kasumi {
namespace {

constexpr int kCell = 20, kReach = 8;  // pixels; of the window around an edge
constexpr double kLeastStep = 0.12;    // encoded
constexpr double kMostResidual = 0.05;
constexpr double kAsSharp = 1.1;         // width over that of the sharpest fifth
constexpr double kLeastCoherence = 0.9;  // of gradients in the window: one straight edge

// offset, angle, dark, bright, point spread, sharpening; by how much of itself the picture grows brighter in a pixel to
// the right, and down: surfaces are never lit quite evenly, and a slope would pass for blur
constexpr int kUnknowns = 8;
using EdgeParameters = Eigen::Matrix<double, kUnknowns, 1>;

struct EdgePixel {
  double x, y, value;
};

double encoded_grey(const Response& response, double light) {
  return response.to_encoded(glm::dvec3(std::clamp(light, 0.0, 1.0))).g;
}

// The encoded edge without sharpening, by distance from its line.
class EdgeProfile {
 public:
  EdgeProfile(const EdgeParameters& p, const Response& response) {
    const double width = std::sqrt(p[4] * p[4] + 1.0 / 12.0);  // the pixel's square, seen from any side
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double share = 0.5 * std::erfc(-place(i) / (width * std::sqrt(2.0)));
      values_[i] = encoded_grey(response, p[2] + (p[3] - p[2]) * share);
    }
  }
  double at(double distance) const {
    const double where = std::clamp((distance + kEnd) / kSpacing, 0.0, static_cast<double>(values_.size()) - 1.001);
    const auto i = static_cast<std::size_t>(where);
    return std::lerp(values_[i], values_[i + 1], where - static_cast<double>(i));
  }

 private:
  static constexpr double kEnd = 14.0, kSpacing = 0.0625;
  static double place(std::size_t i) { return static_cast<double>(i) * kSpacing - kEnd; }
  std::array<double, static_cast<std::size_t>(2 * kEnd / kSpacing) + 1> values_{};
};

// Encoded, at a place from the window's middle.
double drawn_value(const EdgeParameters& p, const EdgeProfile& profile, double x, double y) {
  const double c = std::cos(p[1]), s = std::sin(p[1]), distance = c * x + s * y - p[0];
  double around = 0.0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u)
      around += (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * profile.at(distance + c * u + s * v);
  const double own = profile.at(distance);
  const double lit = 1.0 + p[6] * x + p[7] * y;
  return lit * (own + p[5] * (own - around));
}

Eigen::VectorXd residuals(const std::vector<EdgePixel>& pixels, const EdgeParameters& p, const Response& response) {
  const EdgeProfile profile(p, response);
  Eigen::VectorXd off(static_cast<Eigen::Index>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i)
    off[static_cast<Eigen::Index>(i)] = drawn_value(p, profile, pixels[i].x, pixels[i].y) - pixels[i].value;
  return off;
}

EdgeParameters within_bounds(EdgeParameters p) {
  p[2] = std::clamp(p[2], 0.0, 1.0);
  p[3] = std::clamp(p[3], 0.0, 1.0);
  p[4] = std::clamp(std::abs(p[4]), 0.0, 4.0);
  p[5] = std::clamp(p[5], -0.2, 3.0);
  return p;
}

// Levenberg and Marquardt's.
double fit(const std::vector<EdgePixel>& pixels, const Response& response, EdgeParameters& p) {
  double damping = 1e-3;
  Eigen::VectorXd off = residuals(pixels, p, response);
  for (int round = 0; round < 30; ++round) {
    Eigen::MatrixXd slopes(off.size(), kUnknowns);
    for (int k = 0; k < kUnknowns; ++k) {
      EdgeParameters moved = p;
      moved[k] += 1e-4;
      slopes.col(k) = (residuals(pixels, moved, response) - off) / 1e-4;
    }
    const Eigen::Matrix<double, kUnknowns, kUnknowns> normal = slopes.transpose() * slopes;
    bool better = false;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      Eigen::Matrix<double, kUnknowns, kUnknowns> damped = normal;
      damped.diagonal() += damping * normal.diagonal() + EdgeParameters::Constant(1e-9);
      const EdgeParameters step = damped.ldlt().solve(slopes.transpose() * off);
      const EdgeParameters next = within_bounds(p - step);
      const Eigen::VectorXd left = residuals(pixels, next, response);
      better = left.squaredNorm() < off.squaredNorm();
      if (better) {
        const bool done = left.squaredNorm() > (1.0 - 1e-6) * off.squaredNorm();
        p = next;
        off = left;
        damping = std::max(0.3 * damping, 1e-9);
        if (done) return std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
      } else {
        damping *= 5.0;
      }
    }
    if (!better) break;
  }
  return std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
}

glm::dvec2 gradient(const Image<float>& luma, int x, int y) {
  return 0.5 * glm::dvec2(luma.at(x + 1, y) - luma.at(x - 1, y), luma.at(x, y + 1) - luma.at(x, y - 1));
}

// The steepest pixel of a cell whose window lies within the picture.
std::optional<glm::ivec2> steepest(const Image<float>& luma, int left, int top) {
  std::optional<glm::ivec2> found;
  double most = 0.03;
  const int margin = kReach + 2;
  for (int y = std::max(top, margin); y < std::min(top + kCell, luma.height() - margin); ++y)
    for (int x = std::max(left, margin); x < std::min(left + kCell, luma.width() - margin); ++x) {
      const auto slope = gradient(luma, x, y);
      const double size = std::hypot(slope.x, slope.y);
      if (size <= most) continue;
      most = size;
      found = glm::ivec2{x, y};
    }
  return found;
}

std::optional<DrawnEdge> drawn_edge(const Image<float>& luma, const Response& response, const glm::ivec2& at) {
  double xx = 0.0, xy = 0.0, yy = 0.0, sx = 0.0, sy = 0.0;
  for (int v = -kReach; v <= kReach; ++v)
    for (int u = -kReach; u <= kReach; ++u) {
      const auto g = gradient(luma, at.x + u, at.y + v);
      xx += g.x * g.x, xy += g.x * g.y, yy += g.y * g.y;
      sx += g.x, sy += g.y;
    }
  const double coherence = std::hypot(xx - yy, 2.0 * xy) / std::max(xx + yy, 1e-12);
  if (coherence < kLeastCoherence) return std::nullopt;
  double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  if (std::cos(angle) * sx + std::sin(angle) * sy < 0.0) angle += kPi;
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<EdgePixel> pixels;
  std::vector<double> dark, bright;
  for (int v = -kReach; v <= kReach; ++v)
    for (int u = -kReach; u <= kReach; ++u) {
      const double value = static_cast<double>(luma.at(at.x + u, at.y + v));
      if (value <= 0.008 || value >= 0.985) return std::nullopt;
      const double distance = c * u + s * v;
      if (std::abs(distance) > kReach) continue;
      pixels.push_back({static_cast<double>(u), static_cast<double>(v), value});
      if (distance < -4.0) dark.push_back(value);
      if (distance > 4.0) bright.push_back(value);
    }
  if (dark.size() < 20 || bright.size() < 20) return std::nullopt;
  const double low = median(dark), high = median(bright);
  if (high - low < kLeastStep) return std::nullopt;
  EdgeParameters p;
  p << 0.0, angle, response.to_light(glm::dvec3(low)).g, response.to_light(glm::dvec3(high)).g, 0.6, 0.3, 0.0, 0.0;
  const double residual = fit(pixels, response, p) / (high - low);
  if (residual > kMostResidual || p[4] >= 3.9) return std::nullopt;
  DrawnEdge edge{glm::dvec2(at) + p[0] * glm::dvec2(std::cos(p[1]), std::sin(p[1])),
                 Radians{p[1]},
                 p[4],
                 p[5],
                 high - low,
                 residual,
                 at,
                 {}};
  std::ranges::copy(p, edge.fitted.begin());
  return edge;
}

// How wide it is drawn, blur and sharpening together: a step over its steepness, pixels. Better known than either.
double drawn_width(const DrawnEdge& edge) {
  const double width = std::sqrt(edge.point_spread_px * edge.point_spread_px + 1.0 / 12.0);
  const double c = std::cos(edge.normal.value), s = std::sin(edge.normal.value);
  double around = 0.0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u)
      around += (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * std::exp(-0.5 * std::pow((c * u + s * v) / width, 2));
  return width / (1.0 + edge.sharpening * (1.0 - around));
}

// The edge with another blur and sharpening, rounded in the blocks in which the picture has it, and found again.
std::optional<DrawnEdge> found_again(const DrawnEdge& edge, const glm::dvec2& sharpness, const Response& response,
                                     const JpegSteps& jpeg) {
  constexpr int kSize = 4 * kBlockSide, kMargin = kReach + 2;  // the window with its gradients, wherever it lies
  EdgeParameters p = Eigen::Map<const EdgeParameters>(edge.fitted.data());
  p[4] = sharpness.x;
  p[5] = sharpness.y;
  const EdgeProfile profile(p, response);
  const glm::ivec2 origin = (edge.window - kMargin) / kBlockSide * kBlockSide;
  Image<float> luma(kSize, kSize);
  for (int top = 0; top < kSize; top += kBlockSide)
    for (int left = 0; left < kSize; left += kBlockSide) {
      JpegBlock block{};
      const auto at = [](int x, int y) { return static_cast<std::size_t>(kBlockSide * y + x); };
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x) {
          const glm::ivec2 place = origin + glm::ivec2(left + x, top + y) - edge.window;
          block[at(x, y)] = std::round(255.0 * drawn_value(p, profile, place.x, place.y)) - 128.0;
        }
      JpegBlock coefficients = coefficients_of(block);
      for (std::size_t i = 0; i < coefficients.size(); ++i) {
        const double step = step_of(jpeg.luma, i);
        coefficients[i] = step * std::round(coefficients[i] / step);
      }
      block = samples_of(coefficients);
      for (int y = 0; y < kBlockSide; ++y)
        for (int x = 0; x < kBlockSide; ++x)
          luma.at(left + x, top + y) = static_cast<float>(std::round(block[at(x, y)] + 128.0) / 255.0);
    }
  return drawn_edge(luma, response, edge.window - origin);
}

// Their mean with weights, and how far it may be off.
std::pair<double, double> weighted_mean(std::span<const DrawnEdge> edges, double DrawnEdge::*value) {
  double weights = 0.0, sum = 0.0, square = 0.0, squares = 0.0;
  for (const auto& edge : edges) {
    const double weight = 1.0 / (edge.residual * edge.residual + 1e-4);
    weights += weight;
    sum += weight * edge.*value;
    square += weight * edge.*value * edge.*value;
    squares += weight * weight;
  }
  const double mean = sum / weights;
  return {mean, std::sqrt(std::max(square / weights - mean * mean, 0.0) * squares / (weights * weights))};
}

// Blur and sharpening that JPEG's rounding turns into those found in these edges.
glm::dvec2 before_rounding(std::span<const DrawnEdge> edges, const glm::dvec2& found, const Response& response,
                           const JpegSteps& jpeg) {
  constexpr int kTurns = 4;
  glm::dvec2 before = found;
  for (int turn = 0; turn < kTurns; ++turn) {
    std::vector<DrawnEdge> seen, again;
    for (const auto& edge : edges)
      if (auto drawn = found_again(edge, before, response, jpeg)) {
        drawn->residual = edge.residual;  // the same weight
        seen.push_back(edge);
        again.push_back(*drawn);
      }
    if (2 * seen.size() < edges.size()) return found;
    before.x += weighted_mean(seen, &DrawnEdge::point_spread_px).first -
                weighted_mean(again, &DrawnEdge::point_spread_px).first;
    before.y += weighted_mean(seen, &DrawnEdge::sharpening).first - weighted_mean(again, &DrawnEdge::sharpening).first;
    before = glm::clamp(before, glm::dvec2(0.0, -0.2), glm::dvec2(4.0, 3.0));
  }
  return before;
}

}  // namespace

std::vector<DrawnEdge> find_drawn_edges(const Image<float>& luma, const Response& response,
                                        const std::optional<glm::ivec4>& box) {
  const glm::ivec4 part = box.value_or(glm::ivec4{0, 0, luma.width(), luma.height()});
  std::vector<DrawnEdge> edges;
  for (int top = part.y; top < part.w; top += kCell)
    for (int left = part.x; left < part.z; left += kCell)
      if (const auto at = steepest(luma, left, top))
        if (const auto edge = drawn_edge(luma, response, *at)) edges.push_back(*edge);
  return edges;
}

std::optional<DrawnSharpness> sharpness_of(std::span<const DrawnEdge> edges, const Response& response,
                                           const JpegSteps* jpeg) {
  constexpr std::size_t kFewest = 5;
  if (edges.size() < kFewest) return std::nullopt;
  std::vector<double> widths;
  for (const auto& edge : edges) widths.push_back(drawn_width(edge));
  const double sharp = quantile(widths, 0.2);
  std::vector<DrawnEdge> sharper;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (widths[i] <= kAsSharp * sharp) sharper.push_back(edges[i]);
  if (sharper.size() < kFewest) return std::nullopt;
  // Pairs of blur and sharpening that nearly make up for each other scatter along a line: the middle of it is taken.
  const auto [spread, spread_sigma] = weighted_mean(sharper, &DrawnEdge::point_spread_px);
  const auto [amount, amount_sigma] = weighted_mean(sharper, &DrawnEdge::sharpening);
  glm::dvec2 found{spread, amount};
  if (jpeg) found = before_rounding(sharper, found, response, *jpeg);
  return DrawnSharpness{found.x, spread_sigma, std::max(found.y, 0.0), amount_sigma, static_cast<int>(sharper.size())};
}

}  // namespace kasumi
