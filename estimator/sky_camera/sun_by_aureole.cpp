#include "estimator/sky_camera/sun_by_aureole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/square.hpp"
#include "estimator/sky_camera/aureole_fit.hpp"
#include "estimator/sky_camera/sky_slopes.hpp"
#include "estimator/sky_camera/sun_core.hpp"

namespace kasumi {

namespace {

constexpr double kWorthALook = 0.3;                  // confidence
constexpr double kOfSharpDisc = 0.95;                // confidence
constexpr double kSharpRim = 0.96;                   // of its level
constexpr double kSmooth = 0.5, kBrightest = 0.4;    // of the sky around a sharp disc: explained, above
constexpr Radians kLowestDisc = from_degrees(10.0);  // elevation of a sharp one
constexpr int kLargestBlobs = 3, kMeetings = 3;      // candidates of each sort; chosen: more cost time alone

// Where the sun may be: the middles of the largest clipped areas, and where the sky's slopes meet.
std::vector<SunDirection> likely_places(const CoarseMaps& sky, const SkyPicture& picture, const Camera& camera) {
  std::vector<SunDirection> places;
  const auto add = [&](const glm::dvec2& place) {
    const auto element = sky.picture_element(place);
    if (const auto direction = camera.direction_at(picture.camera_pixel(element.x, element.y)))
      places.push_back(*direction);
  };
  cv::Mat1b clipped(sky.clipped.height(), sky.clipped.width());
  for (int y = 0; y < clipped.rows; ++y)
    for (int x = 0; x < clipped.cols; ++x) clipped(y, x) = sky.clipped.at(x, y);
  cv::Mat1i labels, stats;
  cv::Mat1d centroids;
  const int count = cv::connectedComponentsWithStats(clipped, labels, stats, centroids, 8, CV_32S);
  std::vector<int> order;
  for (int label = 1; label < count; ++label) order.push_back(label);
  const auto largest = std::min(order.size(), static_cast<std::size_t>(kLargestBlobs));
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(largest), std::ranges::greater{},
                            [&](int label) { return stats(label, cv::CC_STAT_AREA); });
  for (std::size_t i = 0; i < largest; ++i) add({centroids(order[i], 0), centroids(order[i], 1)});
  for (const glm::vec2& place : where_slopes_meet(sky, kMeetings)) add(glm::dvec2(place));
  return places;
}

// What both ways of looking say of one place.
struct Looks {
  AureoleFit aureole;
  std::optional<SunCore> core;
  Radians shift;  // of the aureole's centre if only its inner part is fitted
  Radians apart;  // aureole's centre and core
};

// Variances [rad^2]. Beyond its aureole the sky is brighter on one side, towards the horizon or a cloud. That moves an
// isophote of radius r by slope * r^2 / fall; the fit sees some of the slope, a spot's middle nothing of it.
constexpr double kSlopeLeft = 0.7, kSlopeOfSky = 2.0;  // 1/rad
constexpr double kLeastError = 0.003;                  // [rad]

double variance_of(const AureoleFit& aureole) {
  const double fall = std::clamp(aureole.fall, 0.05, 3.0);
  return square(aureole.sigma.value) + square(kSlopeLeft * square(aureole.rim.value) / fall) + square(kLeastError);
}
double variance_of(const SunCore& core, const AureoleFit& aureole) {
  const double fall = std::clamp(aureole.fall, 0.3, 3.0), radius = core.radius.value;
  return square(kSlopeOfSky * square(radius) / fall) + square(0.2 * (1.0 - core.roundness) * radius) +
         square(kLeastError);
}
// An isophote's middle, corrected for its shift by a sky that brightens towards the horizon.
SunDirection unmoved(const SunCore& core, const AureoleFit& aureole) {
  const SunDirection& at = core.direction;
  const double sine = std::hypot(at.x, at.y);
  if (sine < 1e-6) return at;
  const double fall = std::clamp(aureole.fall, 0.3, 3.0);
  const double slope = 0.6 * sine / (std::max(at.z, 0.0) + 0.1);
  const double shift = std::min(slope * square(core.radius.value) / fall, core.radius.value);
  return glm::normalize(at + shift * SunDirection{-at.x * at.z / sine, -at.y * at.z / sine, sine});
}
// In units of what they may differ by.
double apart_of(const Looks& looks) {
  return looks.apart.value / std::sqrt(variance_of(looks.aureole) + variance_of(*looks.core, looks.aureole));
}
bool cores_agree(const Looks& looks) {
  return looks.core && looks.core->level > 0.3 && apart_of(looks) < 3.0;
}

// The inverse-variance weighted mean of both centres.
SunBlob blob_of(const Looks& looks, const SunDirection& aureole, const SunDirection& core) {
  const AureoleFit& a = looks.aureole;
  const double of_aureole = variance_of(a);
  SunBlob blob;
  blob.direction = aureole;
  blob.radius = a.hole;
  blob.sigma = Radians{std::sqrt(of_aureole)};
  if (!cores_agree(looks)) return blob;
  const double of_core = variance_of(*looks.core, a);
  blob.direction = glm::normalize(aureole / of_aureole + core / of_core);
  blob.radius = looks.core->radius;
  blob.sigma = Radians{std::sqrt(1.0 / (1.0 / of_aureole + 1.0 / of_core))};
  return blob;
}
SunBlob blob_of(const Looks& looks) {
  return blob_of(looks, looks.aureole.centre, looks.core ? looks.core->direction : SunDirection{});
}

// The same, corrected for a clear sky's brightening towards the horizon, which moves either centre. Clouds follow no
// such rule, so the correction is for smooth surroundings only. The classifier of suns was trained without it.
SunDirection without_horizon(const Looks& looks, const CoarseMaps& sky, const SunBlob& blob) {
  constexpr double kClear = 0.95;  // explained
  const AureoleFit& a = looks.aureole;
  if (a.explained < kClear || !cores_agree(looks)) return blob.direction;
  const auto again = fit_aureole(sky, a.centre, {.less_horizon = true});
  if (!again || angle_between(again->centre, a.centre) > 3.0 * blob.sigma) return blob.direction;
  return blob_of(looks, again->centre, unmoved(*looks.core, a)).direction;
}

// Features of the sun's surroundings.
using Signs = std::array<double, 10>;
Signs signs_of(const Looks& looks) {
  const AureoleFit& a = looks.aureole;
  const auto ln = [](double x, double low, double high) { return std::log(std::clamp(x, low, high)); };
  const bool agree = cores_agree(looks);
  return {1.0,
          a.explained,
          ln(a.fall, 0.02, 4.0),
          ln(a.rise, 0.02, 3.0),
          0.1 * std::min(to_degrees(a.hole), 40.0),
          agree ? std::exp(-0.5 * square(apart_of(looks))) : 0.0,
          looks.core ? looks.core->level : 0.0,
          std::clamp(a.above, -2.0, 4.0),
          ln(a.clipped, 0.02, 1.0),
          ln(to_degrees(looks.shift) + 0.1, 0.1, 5.0)};
}

// The probability that the sun is within 2 deg. Factors by logistic regression on generated pictures
// (tests/estimator/sky_camera/sun_pictures, development).
double confidence_of(const Signs& signs) {
  constexpr Signs kFactors{-2.69, 1.92, 0.7, 0.26, 0.53, 2.08, 0.65, 0.3, 0.56, -0.48};  // fitted as said above
  double sum = 0.0;
  for (std::size_t k = 0; k < signs.size(); ++k) sum += kFactors[k] * signs[k];
  return 1.0 / (1.0 + std::exp(-sum));
}

// Both looks at a place, or none.
std::optional<Looks> look_at(const CoarseMaps& sky, const SkyPicture& picture, const Camera& camera,
                             const SunDirection& place, const SunBlobLimits& options) {
  const auto aureole = fit_aureole(sky, place);
  if (!aureole || aureole->hole > options.largest_radius) return std::nullopt;
  Looks looks{*aureole, std::nullopt, {}, {}};
  looks.core = sun_core(picture, camera, aureole->centre, Radians{1.4 * aureole->hole.value + 0.08}, options.saturated);
  if (looks.core) looks.apart = angle_between(looks.core->direction, aureole->centre);
  if (confidence_of(signs_of(looks)) < kWorthALook) return looks;
  const auto inner = fit_aureole(sky, aureole->centre, {0.4, from_degrees(5.0)});
  looks.shift = inner ? angle_between(inner->centre, aureole->centre) : from_degrees(5.0);
  return looks;
}

// A lens that hardly spreads its light leaves a small disc and no steep aureole, so that the sky around hardly locates
// it; but nothing else is a round white spot in a sky that is smooth and brightest around it. Near the horizon the sky
// is brightest everywhere, and walls and water are white.
std::optional<SunBlob> sharp_disc(const CoarseMaps& sky, const SkyPicture& picture, const Camera& camera,
                                  const SunDirection& place, const SunBlobLimits& options) {
  const auto core = sun_core(picture, camera, place, from_degrees(4.0), options.saturated, kSharpRim);
  if (!core || core->level < options.saturated || core->radius > from_degrees(2.5) || core->roundness < 0.65 ||
      core->radius < from_degrees(0.5) || core->direction.z < std::sin(kLowestDisc.value))
    return std::nullopt;
  const auto around = fit_aureole(sky, core->direction, {1.0, from_degrees(10.0), true});
  if (!around || around->explained < kSmooth || around->above < kBrightest) return std::nullopt;
  SunBlob blob;
  blob.direction = core->direction;
  blob.radius = core->radius;
  blob.confidence = kOfSharpDisc;
  blob.sigma = Radians{std::sqrt(variance_of(*core, *around))};
  return blob;
}

}  // namespace

std::optional<SunBlob> sun_by_aureole(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options) {
  const CoarseMaps sky = coarse_sky(picture, camera, options.saturated);
  if (!(sky.resolution.value > 0.0)) return std::nullopt;
  struct Found : SunBlob {
    std::optional<Looks> looks;
  };
  std::vector<Found> blobs;
  for (const SunDirection& place : likely_places(sky, picture, camera)) {
    const bool known = std::ranges::any_of(blobs, [&](const Found& blob) {
      return angle_between(blob.direction, place).value < blob.radius.value + from_degrees(3.0).value;
    });
    if (known) continue;
    if (const auto disc = sharp_disc(sky, picture, camera, place, options)) {
      blobs.push_back({*disc, std::nullopt});
      continue;
    }
    const auto looks = look_at(sky, picture, camera, place, options);
    if (!looks) continue;
    blobs.push_back({blob_of(*looks), looks});
    blobs.back().confidence = confidence_of(signs_of(*looks));
  }
  if (blobs.empty()) return std::nullopt;
  Found best = *std::ranges::max_element(blobs, {}, &Found::confidence);
  double rival = 0.0;
  for (const SunBlob& blob : blobs)
    if (angle_between(blob.direction, best.direction) > from_degrees(5.0)) rival = std::max(rival, blob.confidence);
  best.confidence *= 1.0 - 0.5 * rival;
  if (options.expected)
    best.confidence = confidence_where_expected(best.confidence, best.direction, best.sigma, *options.expected);
  if (best.confidence < options.least_by_aureole || best.sigma > options.largest_by_aureole) return std::nullopt;
  if (best.looks) best.direction = without_horizon(*best.looks, sky, best);
  const auto pixel = camera.pixel_of(best.direction);
  if (!pixel) return std::nullopt;
  best.pixel = *pixel;
  return best;
}

}  // namespace kasumi
