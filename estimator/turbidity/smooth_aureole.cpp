#include "estimator/turbidity/smooth_aureole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/turbidity/clear_form.hpp"
#include "estimator/turbidity/element_looks.hpp"
#include "estimator/turbidity/expected_elements.hpp"

namespace kasumi {

namespace {

constexpr Radians kGlare = from_degrees(2.0);    // around the sun: the lens's, no sky
constexpr Radians kRing = from_degrees(6.0);     // the aureole from the glare to here shows whether the sun is covered
constexpr Radians kMargin = from_degrees(2.0);   // around what differs: a cloud's edges are as soft
constexpr Radians kAround = from_degrees(60.0);  // the sky around the sun, which decides whether the form is trusted
constexpr double kTrusted = 0.9;                 // of what looked clear there must agree; else clouds were fitted
constexpr double kAnchored = 0.1;                // of the sky there looked clear: less says nothing

struct Share {
  double some = 0.0, all = 0.0;
  void count(bool counts) {
    all += 1.0;
    if (counts) some += 1.0;
  }
  double value() const { return all > 0.0 ? some / all : 0.0; }
};

std::vector<LookedAt> places_of(const ElementLooks& looks, const ElementGeometry& geometry, const Image<PixelUse>& use,
                                const ClearForm& form, float rough) {
  constexpr double kPlaces = 4000.0;     // more add nothing
  constexpr float kPerhapsCloud = 0.3f;  // a model's mask may be wrong: what it calls cloud still has a say
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(cv::sum(looks.known)[0] / kPlaces))));
  std::vector<LookedAt> places;
  for (int y = step / 2; y < looks.known.rows; y += step)
    for (int x = step / 2; x < looks.known.cols; x += step) {
      if (looks.known(y, x) == 0.0f) continue;
      LookedAt place{form.at(geometry.direction.at(x, y)), looks.luminance(y, x), looks.colour(y, x), 0.0f};
      if (looks.texture(y, x) < rough) place.weight = use.at(x, y) == PixelUse::clear ? 1.0f : kPerhapsCloud;
      places.push_back(place);
    }
  return places;
}

struct Differences {
  cv::Mat1b compared;              // 1 or 0
  cv::Mat1f by;                    // the difference over its limit; what is textured differs by much
  Share agreeing, still_agreeing;  // around the sun: of all; of what was clear
  Share textured;
  bool trusted() const {
    const Share& share = still_agreeing.all > kAnchored * agreeing.all ? still_agreeing : agreeing;
    return share.value() >= kTrusted;
  }
};
Differences differences(const ElementLooks& looks, const ElementLight& light, const SkyPicture& picture,
                        const ElementGeometry& geometry, const Camera& camera, const Image<PixelUse>& use,
                        const SunDirection& sun, const ClearForm& form, const ClearFormFit& sky, float rough) {
  // The form's own misfit, but no less than what a thin veil makes of it.
  constexpr float kScatters = 4.0f, kLeast = 0.03f, kMostLuminance = 0.12f, kMostColour = 0.10f;
  const float luminance_limit = std::clamp(kScatters * sky.luminance_scatter, kLeast, kMostLuminance);
  const float colour_limit = std::clamp(kScatters * sky.colour_scatter, kLeast, kMostColour);
  constexpr float kTextured = 1e3f;  // whatever the limits
  const glm::dmat3& to_xyz = geometry.light_to_xyz;
  const glm::vec3 luminance_of{to_xyz[0].y, to_xyz[1].y, to_xyz[2].y}, towards_sun(sun);
  const auto around = static_cast<float>(std::cos(kAround.value));
  const cv::Mat1b none(looks.known.size(), std::uint8_t{0});
  Differences found{none.clone(), cv::Mat1f(looks.known.size(), 0.0f), {}, {}, {}};
  cv::Mat1f& by = found.by;
  ExpectedElements elements(geometry, sun, [&](const glm::vec3& direction) {
    const ClearForm::Terms terms = form.at(direction);
    return glm::vec2{sky.luminance_at(terms), sky.colour_at(terms)};
  });
  for (int y = 0; y < none.rows; ++y) {
    elements.begin_row(y);
    for (int x = 0; x < none.cols; ++x) {
      const bool known = looks.known(y, x) != 0.0f;
      if (!known && light.use.at(x, y) != PixelUse::saturated) continue;
      const glm::vec3& direction = geometry.direction.at(x, y);
      const glm::vec2 expected = elements.at(x);
      if (known) {
        const float step = looks.luminance_step(y, x);
        by(y, x) =
            std::max(std::abs(looks.luminance(y, x) - expected.x) / (luminance_limit + 0.6f * step),
                     std::abs(looks.colour(y, x) - expected.y) / (colour_limit + 0.6f * looks.colour_step(y, x)));
        const bool textured = looks.texture(y, x) > rough + 0.3f * step;
        if (textured) by(y, x) = kTextured;
        found.textured.count(textured);
      } else {
        // Saturated: it agrees if the form is as bright there or brighter.
        constexpr float kDarker = 0.1f;
        const glm::vec3 least(camera.response.to_light(glm::dvec3(picture.encoded.at(x, y))));
        const float least_luminance = glm::dot(luminance_of, least * geometry.gain.at(x, y));
        by(y, x) = (std::log(least_luminance) - expected.x) / kDarker;
      }
      found.compared(y, x) = 1;
      if (glm::dot(direction, towards_sun) < around) continue;
      found.agreeing.count(by(y, x) <= 1.0f);
      if (use.at(x, y) == PixelUse::clear) found.still_agreeing.count(by(y, x) <= 1.0f);
    }
  }
  return found;
}

// Not 0 where nothing but clear air is seen. Where nearly all agrees, the rest is more likely the form's misfit than a
// small and faint cloud; and a cloud without edges anywhere in the sky is none.
cv::Mat1b agreeing(const Differences& found, bool edges_would_show) {
  // Shares: of places that agree, and of elements with texture, below which there are no edges.
  constexpr double kNearlyAllAgrees = 0.95, kNoEdges = 0.002;
  const bool no_edges = edges_would_show && found.textured.value() < kNoEdges;
  const double limit = no_edges ? 6.0 : found.agreeing.value() > kNearlyAllAgrees ? 2.5 : 1.0;
  cv::Mat1b agrees;
  cv::compare(found.by, limit, agrees, cv::CMP_LE);
  cv::medianBlur(agrees, agrees, 5);  // without single ones: noise
  return agrees;
}

// A closed layer of cloud is smooth, too. But it is neither blue anywhere nor so much brighter around the sun as haze,
// which scatters forwards, makes it.
bool is_air(const ElementLooks& looks, const ClearForm& form, const ClearFormFit& sky, const SunDirection& sun) {
  constexpr float kSkyBlue = -0.35f, kRise = 0.5f;  // ln R/B; ln Y
  if (quantile(some_of(looks, [&](int x, int y) { return looks.colour(y, x); }), 0.1) < kSkyBlue) return true;
  const glm::dvec3 level = glm::cross(sun, glm::dvec3{0.0, 0.0, 1.0});
  const glm::dvec3 aside = glm::length(level) > 1e-6 ? glm::normalize(level) : glm::dvec3{1.0, 0.0, 0.0};
  const auto beside = [&](Radians angle) {
    return sky.luminance_at(form.at(glm::vec3(std::cos(angle.value) * sun + std::sin(angle.value) * aside)));
  };
  return beside(from_degrees(4.0)) - beside(from_degrees(25.0)) > kRise;
}

}  // namespace

SmoothAureole smooth_aureole(const SkyPicture& picture, const ElementGeometry& geometry, const Camera& camera,
                             const Image<PixelUse>& use, const SunDirection& sun) {
  SmoothAureole own{use, 0.0};
  SampleLimits limits;
  limits.least_sun_distance = kGlare;
  const ElementLight light = sky_light(picture, geometry, sun, limits);
  const ElementLooks looks = looks_of(picture, camera, light);
  constexpr int kFew = 800;  // elements: 30 for each of the form's 26 terms
  if (cv::sum(looks.known)[0] < kFew) return own;
  const float rough = looks.rough(5.0, 0.02);  // as CloudMaskLimits has it

  const ClearForm form(sun);
  const auto sky = fit_clear_form(places_of(looks, geometry, use, form, rough));
  if (!sky) return own;
  const Differences found = differences(looks, light, picture, geometry, camera, use, sun, form, *sky, rough);
  if (!found.trusted()) return own;
  const bool air = is_air(looks, form, *sky, sun);
  constexpr float kNoisy = 0.04f;  // of ln light: texture this rough hides a cloud's edge
  const cv::Mat1b agrees = agreeing(found, air && rough < kNoisy);

  std::vector<float> solid_angles = some_of(looks, [&](int x, int y) { return geometry.solid_angle.at(x, y); });
  const double element = std::sqrt(static_cast<double>(median_in_place(solid_angles)));
  const auto margin = static_cast<float>(kMargin.value / element);
  cv::Mat1f apart;  // from what differs, in elements
  cv::distanceTransform(agrees, apart, cv::DIST_L2, 3);
  // A low sun's ring is partly below what is examined: then it reaches further up.
  const double below = std::max(0.0, zenith_angle(sun).value + kRing.value - limits.largest_zenith.value);
  const auto ring_begins = static_cast<float>(std::cos(kGlare.value)),
             ring_ends = static_cast<float>(std::cos(kRing.value + below));
  const glm::vec3 towards_sun(sun);
  Share ring;
  for (int y = 0; y < use.height(); ++y)
    for (int x = 0; x < use.width(); ++x) {
      if (light.use.at(x, y) == PixelUse::outside) continue;
      PixelUse& as = own.use.at(x, y);
      if (found.compared(y, x) != 0 && apart(y, x) > margin && as != PixelUse::outside) as = PixelUse::clear;
      const float cosine = glm::dot(geometry.direction.at(x, y), towards_sun);
      if (cosine < ring_begins && cosine > ring_ends) ring.count(found.compared(y, x) != 0 && agrees(y, x) != 0);
    }
  constexpr double kCovered = 0.6, kUncovered = 0.95;  // shares of the ring
  if (air) own.uncovered_sun = std::clamp((ring.value() - kCovered) / (kUncovered - kCovered), 0.0, 1.0);
  return own;
}

}  // namespace kasumi
