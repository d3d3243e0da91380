#include "calib/pose/fisheye_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/square.hpp"

namespace kasumi {
namespace {

// r / f = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8): the series of 2 tan(theta / 2), whose last term
// stands for all further ones up to 95 deg, and of sin(theta).
struct Projection {
  std::string_view name;
  std::array<double, 4> k;
  std::array<double, 2> odd_sigma;
};
constexpr Projection kStereographic{"stereographic", {1.0 / 12.0, 1.0 / 120.0, 17.0 / 20160.0, 1.15e-4}, {}};
constexpr Projection kOrthographic{"orthographic", {-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362880.0}, {}};
// Between those of all ideal ones.
constexpr Projection kTwoOddTerms{"two odd terms", {-0.03, 0.002, 0.0, 0.0}, {0.06, 0.008}};
constexpr Radians kSineTurnsBack = from_degrees(90.0);

constexpr Radians kEdge = from_degrees(90.0);
constexpr Radians kWidest = from_degrees(100.0);
constexpr Radians kOnePlace = from_degrees(3.0);

double radius_at_edge(const std::array<double, 4>& k) {
  const double t = kEdge.value, t2 = square(t);
  return t * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

struct Candidate {
  std::string_view name;
  LensDescription lens;
  std::array<double, 2> odd_sigma{};
};

// Lenses that have the circle at 90 deg.
std::vector<Candidate> candidates(const ImageCircle& circle) {
  const double r = circle.radius_px;
  std::vector<Candidate> all;
  all.push_back({"equidistant", {IdealFisheyeParameters{circle.centre, r / kEdge.value, false}, kWidest, false}});
  all.push_back(
      {"equisolid",
       {IdealFisheyeParameters{circle.centre, r / (2.0 * std::sin(0.5 * kEdge.value)), true}, kWidest, false}});
  for (const Projection& projection : {kStereographic, kOrthographic, kTwoOddTerms}) {
    const double focal = r / radius_at_edge(projection.k);
    const Radians largest = projection.name == kOrthographic.name ? kSineTurnsBack : kWidest;
    all.push_back({projection.name,
                   {OpencvFisheyeParameters{glm::dvec2(focal), circle.centre, projection.k}, largest, false},
                   projection.odd_sigma});
  }
  return all;
}

std::ptrdiff_t used_of(const OrientationFit& found) {
  return std::count(found.used.begin(), found.used.end(), true);
}

// Suns share an error towards the horizon that looks like a curved lens: two odd terms must improve the fit as much as
// six parameters.
constexpr int kOddTerms = 6;

// Schwarz' criterion over all suns; those that a candidate leaves out cost it three of their sigmas.
double criterion(const OrientationFit& found, double sigma_px, int parameters) {
  constexpr double kLeftOut = 9.0;
  double sum = 0.0;
  for (const double misfit_px : found.misfits_px) sum += std::min(square(misfit_px / sigma_px), 2.0 * kLeftOut);
  return sum + parameters * std::log(2.0 * static_cast<double>(found.used.size()));
}

OrientationPrior prior_of(const Candidate& candidate, const FisheyePrior& prior) {
  OrientationPrior made;
  made.lens = candidate.lens;
  made.to_world = camera_to_world(from_degrees(180.0), from_degrees(90.0), Radians{0.0});
  made.level_sigma = prior.level_sigma;
  // Lenses are put together so well.
  constexpr double kAxisOffCircle = 0.003;  // of the radius
  made.centre_sigma_px = glm::dvec2(std::hypot(prior.circle.sigma_px, kAxisOffCircle * prior.circle.radius_px));
  made.scale_sigma = prior.edge_sigma.value / kEdge.value;
  made.least_sigma_px = 0.2 * prior.sun_sigma_px;
  made.sag_sigma = prior.sag_sigma;
  made.odd_sigma = candidate.odd_sigma;
  return made;
}

// Of 2 sin(theta / 2).
constexpr std::array<double, 4> kEquisolid{-1.0 / 24.0, 1.0 / 1920.0, -1.0 / 322560.0, 1.0 / 92897280.0};

}  // namespace

LensDescription in_stored_pixels(const LensDescription& lens, double pixel_aspect) {
  if (pixel_aspect == 1.0) return lens;
  LensDescription stored = lens;
  OpencvFisheyeParameters fisheye;
  if (const auto* ideal = std::get_if<IdealFisheyeParameters>(&lens.model))
    fisheye = {glm::dvec2(ideal->focal_px), ideal->centre, ideal->equisolid ? kEquisolid : std::array<double, 4>{}};
  else if (const auto* known = std::get_if<OpencvFisheyeParameters>(&lens.model))
    fisheye = *known;
  else
    return lens;
  fisheye.focal_px.x /= pixel_aspect;
  fisheye.centre.x /= pixel_aspect;
  stored.model = fisheye;
  return stored;
}

Result<FisheyeFit> fit_fisheye(std::span<const SunSight> sights, const FisheyePrior& prior) {
  struct Tried {
    FisheyeFit fit;
    double criterion = std::numeric_limits<double>::infinity();
  };
  std::optional<Tried> best;
  std::array<double, 2> best_of{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::optional<Fault> fault;
  const bool one_place = std::ranges::all_of(
      sights, [&](const SunSight& sight) { return angle_between(sight.sun, sights.front().sun) <= kOnePlace; });
  auto asked_for = candidates(prior.circle);
  if (one_place) asked_for.resize(1);
  for (const bool mirrored : {false, true}) {
    if (mirrored && one_place) break;
    for (const Candidate& candidate : asked_for) {
      Candidate asked = candidate;
      asked.lens.mirrored = mirrored;
      const auto found = fit_orientation(sights, prior_of(asked, prior));
      if (!found) {
        if (!fault) fault = found.error();
        continue;
      }
      Tried tried{{*found, candidate.name, mirrored, false},
                  criterion(*found, prior.sun_sigma_px, candidate.odd_sigma[0] > 0.0 ? kOddTerms : 0)};
      auto& of_this = best_of[mirrored ? 1 : 0];
      of_this = std::min(of_this, tried.criterion);
      if (!best || tried.criterion < best->criterion - 1e-9) best = std::move(tried);
    }
  }
  if (!best) return fail(*fault);
  constexpr double kSurely = 9.0;
  best->fit.mirror_known =
      !one_place && used_of(best->fit.orientation) >= 2 && std::abs(best_of[0] - best_of[1]) > kSurely;
  return best->fit;
}

}  // namespace kasumi
