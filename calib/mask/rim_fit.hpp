// Circles and upright ellipses through edges.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "calib/mask/rim_edges.hpp"

namespace kasumi {

// A circle in a picture whose pixels are `aspect` times as wide as high: x is stretched by it first.
struct Rim {
  glm::dvec2 centre{};  // stretched
  double radius = 0.0;  // in rows
  double aspect = 1.0;
  double sigma = 0.0;         // of centre and radius
  double aspect_sigma = 0.0;  // 0: not fitted

  glm::dvec2 point_at(const glm::dvec2& direction, double radius_share = 1.0) const;  // in the picture
  double off(const glm::dvec2& point) const;                                          // outwards, in rows
};
constexpr int kRimSectors = 120;  // sectors in which edges are counted

// Least squares with Tukey's weights on edges within `window` of it that run along it, each sector of the rim weighing
// the same. Empty where edges are in too few sectors.
std::optional<Rim> fit_rim(const std::vector<RimEdge>& edges, const Rim& start, double window, bool with_aspect);

// The edges that run along a rim within `window` of it.
std::vector<RimEdge> edges_along(const std::vector<RimEdge>& edges, const Rim& rim, double window);
int sector_of(const Rim& rim, const glm::dvec2& point);

}  // namespace kasumi
