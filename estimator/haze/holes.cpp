// Holes in a measured range map (H Sect 4.1). H fills each hole with the most common value of its border; because
// surfaces are slanted, this fits the plane that most of the border lies in. A plane in space is linear in 1 / range
// across the picture (exactly for planar depth, nearly so for ranges across a hole).
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "estimator/haze/range.hpp"

namespace kasumi {
namespace {

struct BorderPoint {
  double x = 0.0, y = 0.0, inverse = 0.0;
};
struct Hole {
  std::vector<glm::ivec2> inside;
  std::vector<BorderPoint> border;
};

// inverse = a x + b y + c.
using InversePlane = glm::dvec3;
double inverse_at(const InversePlane& plane, double x, double y) {
  return plane.x * x + plane.y * y + plane.z;
}

constexpr int kTries = 200;          // a plane of half the border is missed once in 10^11 holes
constexpr double kAgrees = 0.01;     // of the range
constexpr double kFlatter = 1.0001;  // a slanted plane is taken only if it explains this much more than a flat one

std::vector<Hole> holes_of(const Image<float>& range, const Image<int>& labels, int count) {
  std::vector<Hole> holes(static_cast<std::size_t>(count));
  for (int y = 0; y < range.height(); ++y)
    for (int x = 0; x < range.width(); ++x) {
      const int label = labels.at(x, y);
      if (label > 0) {
        holes[static_cast<std::size_t>(label - 1)].inside.push_back({x, y});
        continue;
      }
      // A measured pixel counts once for each hole it borders on.
      std::array<int, 4> added{};
      int added_count = 0;
      for (const glm::ivec2 u : {glm::ivec2{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (!labels.contains(x + u.x, y + u.y)) continue;
        const int neighbour = labels.at(x + u.x, y + u.y);
        if (neighbour == 0 ||
            std::find(added.begin(), added.begin() + added_count, neighbour) != added.begin() + added_count)
          continue;
        added[static_cast<std::size_t>(added_count++)] = neighbour;
        holes[static_cast<std::size_t>(neighbour - 1)].border.push_back(
            {static_cast<double>(x), static_cast<double>(y), 1.0 / static_cast<double>(range.at(x, y))});
      }
    }
  return holes;
}

// The plane through three points; none when they are collinear.
bool through(const BorderPoint& a, const BorderPoint& b, const BorderPoint& c, InversePlane& plane) {
  const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y, area = bx * cy - by * cx;
  if (std::abs(area) < 0.5) return false;
  const double bz = b.inverse - a.inverse, cz = c.inverse - a.inverse;
  plane.x = (bz * cy - cz * by) / area;
  plane.y = (bx * cz - cx * bz) / area;
  plane.z = a.inverse - plane.x * a.x - plane.y * a.y;
  return true;
}

// How badly the border fits; each point's misfit is capped at the threshold of agreement (MSAC, Torr and Zisserman).
double misfit(const std::vector<BorderPoint>& border, const InversePlane& plane) {
  double sum = 0.0;
  for (const auto& point : border) {
    const double off = (inverse_at(plane, point.x, point.y) / point.inverse - 1.0) / kAgrees;
    sum += std::min(off * off, 1.0);
  }
  return sum;
}

// Least squares over the points that agree, which reduces the noise of a plane through only three.
InversePlane refined(const std::vector<BorderPoint>& border, const InversePlane& plane) {
  double n = 0.0, mx = 0.0, my = 0.0, mz = 0.0;
  const auto agrees = [&](const BorderPoint& p) {
    return std::abs(inverse_at(plane, p.x, p.y) / p.inverse - 1.0) < kAgrees;
  };
  for (const auto& p : border)
    if (agrees(p)) n += 1.0, mx += p.x, my += p.y, mz += p.inverse;
  if (n < 3.0) return plane;
  mx /= n, my /= n, mz /= n;
  double xx = 0.0, xy = 0.0, yy = 0.0, xz = 0.0, yz = 0.0;
  for (const auto& p : border)
    if (agrees(p)) {
      const double x = p.x - mx, y = p.y - my, z = p.inverse - mz;
      xx += x * x, xy += x * y, yy += y * y, xz += x * z, yz += y * z;
    }
  const double determinant = xx * yy - xy * xy;
  if (determinant < 1e-6 * (xx * yy + 1e-9)) return plane;
  const double a = (xz * yy - yz * xy) / determinant, b = (yz * xx - xz * xy) / determinant;
  const InversePlane better{a, b, mz - a * mx - b * my};
  return misfit(border, better) < misfit(border, plane) ? better : plane;
}

InversePlane plane_of(const std::vector<BorderPoint>& border, std::mt19937_64& random) {
  const auto any = [&] { return border[static_cast<std::size_t>(random() % border.size())]; };
  InversePlane best{0.0, 0.0, any().inverse};
  double least = misfit(border, best);
  for (int i = 0; i < kTries; ++i) {
    const InversePlane flat{0.0, 0.0, any().inverse};
    if (const double off = misfit(border, flat); off < least) {
      least = off;
      best = flat;
    }
  }
  InversePlane leaning{};
  for (int i = 0; i < kTries; ++i)
    if (through(any(), any(), any(), leaning))
      if (const double off = misfit(border, leaning); kFlatter * off < least) {
        least = off;
        best = leaning;
      }
  return refined(border, best);
}

}  // namespace

void fill_holes(Image<float>& range, const Image<int>& labels, int count) {
  const auto holes = holes_of(range, labels, count);
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const auto& [inside, border] = holes[i];
    if (border.empty()) continue;  // the hole is the whole map
    std::mt19937_64 random(i + 1);
    const auto plane = plane_of(border, random);
    const auto [far, near] = std::ranges::minmax(border, {}, &BorderPoint::inverse);
    for (const auto& p : inside)
      range.at(p.x, p.y) = static_cast<float>(1.0 / std::clamp(inverse_at(plane, p.x, p.y), far.inverse, near.inverse));
  }
}

}  // namespace kasumi
