#include "calib/mask/rim_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <glm/geometric.hpp>

#include "calib/mask/rim_candidates.hpp"
#include "calib/mask/rim_edges.hpp"
#include "calib/mask/rim_surround.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostTried = 18, kEllipsesTried = 3;
constexpr double kEllipseGain = 0.25;   // of the rim, that an ellipse must fit and the circle does not
constexpr double kEllipseCovers = 0.8;  // of the rim
constexpr double kLeastSqueeze = 0.05;  // less may be a dome, or a rim of land on one side

std::optional<Rim> refined(const std::vector<RimEdge>& edges, const Rim& rough) {
  std::optional<Rim> rim = rough;
  const auto near = edges_along(edges, rough, std::max(6.0, 0.1 * rough.radius));
  for (const double window : {0.05, 0.025, 0.012})
    if (rim) rim = fit_rim(near, *rim, std::max(2.5, window * rim->radius), false);
  return rim;
}

std::optional<Rim> as_ellipse(const std::vector<RimEdge>& edges, const Rim& circle) {
  std::optional<Rim> rim = circle;
  const auto near = edges_along(edges, circle, 0.16 * circle.radius);
  for (const double window : {0.09, 0.05, 0.025, 0.012})
    if (rim) rim = fit_rim(near, *rim, std::max(2.5, window * rim->radius), true);
  if (!rim || std::abs(rim->aspect - 1.0) < std::max(kLeastSqueeze, 5.0 * rim->aspect_sigma)) return std::nullopt;
  return rim;
}

void rank(std::vector<RankedRim>& rims) {
  std::vector<RimEvidence*> all;
  for (RankedRim& one : rims) all.push_back(&one.evidence);
  compare(all);
  for (RankedRim& one : rims) one.score = score_of(one.evidence);
  std::ranges::stable_sort(rims, std::ranges::greater{}, &RankedRim::score);
}

}  // namespace

double difference(const Rim& a, const Rim& b) {
  return std::max(glm::distance(a.centre, b.centre), std::abs(a.radius - b.radius)) / b.radius;
}

std::vector<RankedRim> ranked_rims(const cv::Mat3f& tones) {
  const auto edges = find_edges(tones);
  std::vector<Rim> rough;
  for (const double reach : {12.0, 30.0})
    for (const Rim& rim : rims_by_surround(surround_of(tones, reach))) rough.push_back(rim);
  for (const Rim& rim : rims_by_votes(edges, tones.size())) rough.push_back(rim);
  std::vector<RankedRim> rims;
  std::vector<Rim> tried;
  for (const Rim& start : rough) {
    if (std::ranges::any_of(tried, [&](const Rim& other) { return difference(other, start) < 0.015; })) continue;
    tried.push_back(start);
    const auto rim = refined(edges, start);
    if (rim && rim->radius > 0.12 * std::min(tones.cols, tones.rows) &&
        std::ranges::none_of(rims, [&](const RankedRim& other) { return difference(other.rim, *rim) < 0.004; }))
      rims.push_back({*rim, evidence_for(*rim, tones, edges), 0.0});
    if (tried.size() >= kMostTried) break;
  }
  rank(rims);
  for (std::size_t i = 0; i < std::min(kEllipsesTried, rims.size()); ++i)
    if (const auto rim = as_ellipse(edges, rims[i].rim)) {
      const auto evidence = evidence_for(*rim, tones, edges);
      if (evidence.covered > kEllipseCovers && evidence.tightly > rims[i].evidence.tightly + kEllipseGain)
        rims[i] = {*rim, evidence, 0.0};
    }
  rank(rims);
  return rims;
}

}  // namespace kasumi
