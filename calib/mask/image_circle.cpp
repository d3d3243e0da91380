#include "calib/mask/image_circle.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "calib/mask/rim_edges.hpp"
#include "calib/mask/rim_search.hpp"

namespace kasumi {
namespace {

constexpr int kLongerSide_px = 360;    // of the picture searched: a circle is found to a fraction of its pixels
constexpr double kUsualSigma = 0.004;  // of the radius: domes, fringes and soft rims move a rim by about as much
constexpr std::size_t kMostOthers = 12;

double confidence_of(const RankedRim& rim) {
  return 1.0 / (1.0 + std::exp(-rim.score));
}

// Circles that lie close together are often parts of the same two rims, of sky and of land, and none quite right: their
// mean, each by the square of its odds.
Rim mean_near(const std::vector<RankedRim>& rims, const RankedRim& best) {
  constexpr double kNeighbour = 0.06;
  Rim mean{{0.0, 0.0}, 0.0, best.rim.aspect};
  double weights = 0.0, variance = 0.0;
  const auto each_near = [&](const auto& use) {
    for (const RankedRim& one : rims)
      if (one.rim.aspect == best.rim.aspect && difference(one.rim, best.rim) < kNeighbour)
        use(one.rim, std::exp(2.0 * (one.score - best.score)));
  };
  each_near([&](const Rim& rim, double weight) {
    mean.centre += weight * rim.centre;
    mean.radius += weight * rim.radius;
    weights += weight;
  });
  mean.centre /= weights;
  mean.radius /= weights;
  each_near([&](const Rim& rim, double weight) {
    const double apart = difference(rim, mean) * mean.radius;
    variance += weight / weights * (apart * apart + rim.sigma * rim.sigma);
  });
  mean.sigma = std::sqrt(variance + std::pow(kUsualSigma * mean.radius, 2.0));
  return mean;
}

bool within(const Rim& inner, const Rim& outer) {
  const double share = inner.radius / outer.radius;
  return inner.aspect == outer.aspect && share > 0.8 && share < 0.975 &&
         glm::distance(inner.centre, outer.centre) + inner.radius < 1.01 * outer.radius;
}

// Not one of the faint rings that lenses throw.
bool is_horizon(const RankedRim& rim) {
  return rim.evidence.covered > 0.7 && rim.evidence.tightly > 0.5 && rim.evidence.relative_step > -1.0;
}
bool is_edge(const RankedRim& rim) {
  constexpr double kWellSeen = 1.5;
  return rim.score > kWellSeen && rim.evidence.relative_step > -1.0;
}

}  // namespace

std::optional<FoundCircle> find_image_circle(const Image<Rgb8>& picture) {
  if (picture.width() < 16 || picture.height() < 16) return std::nullopt;
  const auto small = tones_of(picture, kLongerSide_px);
  const auto rims = ranked_rims(small.tones);
  if (rims.empty()) return std::nullopt;
  const auto in_picture = [&](const Rim& rim) {
    const glm::dvec2 half{0.5 * rim.aspect, 0.5};
    return ImageCircle{small.shrink * (rim.centre + half) - half, small.shrink * rim.radius, small.shrink * rim.sigma};
  };
  const RankedRim& best = rims.front();
  const Rim mean = mean_near(rims, best);
  FoundCircle found;
  found.circle = in_picture(mean);
  found.confidence = confidence_of(best);
  found.pixel_aspect = best.rim.aspect;
  for (const RankedRim& other : rims) {
    if (is_horizon(other) && within(other.rim, mean)) {
      found.horizon = in_picture(other.rim);
      break;
    }
    if (is_edge(other) && within(mean, other.rim)) {
      found.horizon = found.circle;
      found.circle = in_picture(other.rim);
      found.confidence = std::min(found.confidence, confidence_of(other));
      break;
    }
  }
  for (const RankedRim& other : rims)
    if (other.rim.aspect == best.rim.aspect && found.others.size() < kMostOthers)
      found.others.push_back({in_picture(other.rim), confidence_of(other)});
  return found;
}

}  // namespace kasumi
