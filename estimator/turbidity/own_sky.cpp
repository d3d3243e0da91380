#include "estimator/turbidity/own_sky.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/turbidity/clear_form.hpp"
#include "estimator/turbidity/element_maps.hpp"

namespace kasumi {

namespace {

constexpr Radians kNearest = from_degrees(2.0);  // to the sun: nearer, the lens's glare is no sky
constexpr Radians kMargin = from_degrees(4.0);   // around what differs, as today: a cloud agrees here and there by chance
constexpr Radians kAround = from_degrees(60.0);
constexpr Radians kRing = from_degrees(6.0);
constexpr double kStillClear = 0.9;              // of the sky that looked clear before; less: clouds were fitted
constexpr float kFloor = 0.03f;
constexpr float kBlue = -0.35f, kRise = 0.5f;    // ln R/B; ln Y

struct Share {
  double some = 0.0, all = 0.0;
  void count(bool counts) {
    all += 1.0;
    if (counts) some += 1.0;
  }
  double value() const { return all > 0.0 ? some / all : 0.0; }
};

// Relative step of light per step of the encoded value, by channel and level: how finely dark elements are quantised.
class Steps {
 public:
  Steps(const Response& response, double quantum) {
    for (std::size_t i = 1; i < steps_.size(); ++i) {
      const glm::dvec3 level{static_cast<double>(i) / kLast};
      steps_[i] = glm::vec3(quantum * response.slope(level) / glm::max(response.to_light(level), glm::dvec3{1e-9}));
    }
    steps_[0] = steps_[1];
  }
  glm::vec3 at(const glm::vec3& encoded) const { return {step(encoded, 0), step(encoded, 1), step(encoded, 2)}; }

 private:
  static constexpr int kLast = 255;
  float step(const glm::vec3& encoded, int c) const {
    return steps_[static_cast<std::size_t>(std::clamp(encoded[c], 0.0f, 1.0f) * kLast)][c];
  }
  std::array<glm::vec3, kLast + 1> steps_{};
};

// What is compared, per element.
struct Looks {
  cv::Mat1f known;              // 1 or 0
  cv::Mat1f luminance, colour;  // ln Y, ln R/B
  cv::Mat1f step_y, step_c;     // of their quantisation
};
Looks looks_of(const SkyPicture& picture, const SkyGeometry& geometry, const Camera& camera, const SkyLight& sky) {
  const int width = sky.use.width(), height = sky.use.height();
  const Steps steps(camera.response, picture.quantum);
  const cv::Mat1f zero(height, width, 0.0f);
  Looks looks{zero.clone(), zero.clone(), zero.clone(), zero.clone(), zero.clone()};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (sky.use.at(x, y) != PixelUse::clear) continue;
      const glm::vec3& rgb = sky.light.at(x, y);
      const glm::vec3 step = steps.at(picture.encoded.at(x, y));
      looks.known(y, x) = 1.0f;
      looks.luminance(y, x) = sky.log_luminance.at(x, y);
      looks.colour(y, x) = std::log(rgb.r / rgb.b);
      looks.step_y(y, x) = step.g;
      looks.step_c(y, x) = glm::length(glm::vec2{step.r, step.b});
    }
  return looks;
}

}  // namespace

OwnSky own_sky(const SkyPicture& picture, const SkyGeometry& geometry, const Camera& camera,
               const Image<PixelUse>& use, const SunDirection& sun) {
  OwnSky own{use, 0.0};
  SampleLimits limits;
  limits.least_sun_distance = kNearest;
  const SkyLight light = sky_light(picture, geometry, camera, sun, limits);
  const Looks looks = looks_of(picture, geometry, camera, light);
  const int width = use.width(), height = use.height();
  const cv::Mat1f texture = texture_of(looks.luminance, looks.known);
  const cv::Mat1f luminance = mean_over(looks.luminance, looks.known, 3), colour = mean_over(looks.colour, looks.known, 3);
  std::vector<float> unevenness;
  std::vector<float> solid_angles;
  for (int y = 0; y < height; y += 2)
    for (int x = 0; x < width; x += 2)
      if (looks.known(y, x) != 0.0f) {
        unevenness.push_back(texture(y, x));
        solid_angles.push_back(geometry.solid_angle.at(x, y));
      }
  if (unevenness.size() < 200) return own;
  const float rough = std::max(0.02f, 5.0f * quantile(unevenness, 0.25));
  const double element = std::sqrt(static_cast<double>(median_in_place(solid_angles)));

  const ClearForm form(sun);
  constexpr double kPlaces = 4000.0;
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(4.0 * static_cast<double>(unevenness.size()) / kPlaces))));
  std::vector<LookedAt> places;
  for (int y = step / 2; y < height; y += step)
    for (int x = step / 2; x < width; x += step) {
      if (looks.known(y, x) == 0.0f) continue;
      LookedAt p{form.at(geometry.direction.at(x, y)), luminance(y, x), colour(y, x), 0.0f};
      const bool clear = use.at(x, y) == PixelUse::clear;
      if (texture(y, x) < rough) p.weight = clear ? 1.0f : 0.3f;
      places.push_back(p);
    }
  const auto sky = fit_clear_form(std::move(places));
  if (!sky) return own;

  // What differs from the form, or is textured. A saturated element agrees if the form is at least as bright there.
  const float luminance_limit = std::clamp(4.0f * sky->luminance_scatter, kFloor, 0.12f);
  const float colour_limit = std::clamp(4.0f * sky->colour_scatter, kFloor, 0.10f);
  const glm::vec3 luminance_of{geometry.light_to_xyz[0].y, geometry.light_to_xyz[1].y, geometry.light_to_xyz[2].y};
  cv::Mat1b differs(height, width, std::uint8_t{0}), compared(height, width, std::uint8_t{0});
  Share still_clear, agreeing;  // within 60 deg of the sun
  const auto around = static_cast<float>(std::cos(kAround.value));
  const glm::vec3 towards_sun(sun);
  std::vector<float> colours;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool known = looks.known(y, x) != 0.0f;
      if (!known && light.use.at(x, y) != PixelUse::saturated) continue;
      const glm::vec3& direction = geometry.direction.at(x, y);
      const ClearForm::Terms terms = form.at(direction);
      compared(y, x) = 1;
      if (known) {
        const float dy = std::abs(luminance(y, x) - sky->luminance_at(terms));
        const float dc = std::abs(colour(y, x) - sky->colour_at(terms));
        const float step_y = looks.step_y(y, x), step_c = looks.step_c(y, x);
        differs(y, x) = dy > luminance_limit + 0.6f * step_y || dc > colour_limit + 0.6f * step_c ||
                        texture(y, x) > rough + 0.3f * step_y;
        if ((x + y) % 8 == 0) colours.push_back(colour(y, x));
      } else {
        const glm::dvec3 at_least = camera.response.to_light(glm::dvec3(picture.encoded.at(x, y)));
        const float y_least = glm::dot(luminance_of, glm::vec3(at_least) * geometry.gain.at(x, y));
        differs(y, x) = sky->luminance_at(terms) < std::log(y_least) - 0.1f;
      }
      if (glm::dot(direction, towards_sun) < around) continue;
      agreeing.count(differs(y, x) == 0);
      if (use.at(x, y) == PixelUse::clear) still_clear.count(differs(y, x) == 0);
    }
  if (std::getenv("OWN_DEBUG")) {
    std::printf("  own: scatter %.3f %.3f rough %.3f limits %.3f %.3f still %.3f of %.3f agreeing %.3f\n", double(sky->luminance_scatter), double(sky->colour_scatter), double(rough), double(luminance_limit),double(colour_limit), still_clear.value(), still_clear.all/(agreeing.all+1), agreeing.value());
    static int n = 0;
    cv::Mat3b m(height, width, cv::Vec3b(0, 0, 0));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const glm::vec3 e = picture.encoded.at(x, y);
        m(y, x) = cv::Vec3b(e.b * 255, e.g * 255, differs(y, x) ? 255 : e.r * 255);
        if (use.at(x, y) == PixelUse::cloud) m(y, x)[1] = 255;
      }
    cv::imwrite(std::string(std::getenv("OWN_DEBUG")) + "-" + std::to_string(n++) + ".png", m);
  }
  const bool anchored = still_clear.all > 0.1 * agreeing.all;
  if (anchored ? still_clear.value() < kStillClear : agreeing.value() < kStillClear) return own;
  cv::medianBlur(differs, differs, 5);
  cv::Mat1f apart;  // from the nearest that differs, in elements
  cv::distanceTransform(1 - differs, apart, cv::DIST_L2, 3);
  const auto margin = static_cast<float>(kMargin.value / element);
  const auto ring_inner = static_cast<float>(std::cos(kNearest.value)), ring_outer = static_cast<float>(std::cos(kRing.value + std::max(0.0, zenith_angle(sun).value + kRing.value - limits.largest_zenith.value)));
  Share ring;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (geometry.open.at(x, y) == 0) continue;
      const bool agrees = compared(y, x) != 0 && apart(y, x) > margin;
      PixelUse& as = own.use.at(x, y);
      if (agrees && (as == PixelUse::cloud || as == PixelUse::near_sun || as == PixelUse::saturated)) as = PixelUse::clear;
      const float cosine = glm::dot(geometry.direction.at(x, y), towards_sun);
      if (cosine < ring_inner && cosine > ring_outer && light.use.at(x, y) != PixelUse::outside) ring.count(compared(y, x) != 0 && differs(y, x) == 0);
    }
  // A closed layer of cloud is smooth, too, but neither blue anywhere nor much brighter around the sun.
  const auto level_at = [&](double degrees) {
    const glm::dvec3 side = glm::normalize(glm::cross(glm::dvec3(sun), glm::dvec3(0.0, 0.0, 1.0)) + glm::dvec3(1e-6, 0.0, 0.0));
    const double angle = from_degrees(degrees).value;
    return sky->luminance_at(form.at(glm::vec3(std::cos(angle) * glm::dvec3(sun) + std::sin(angle) * side)));
  };
  const bool blue = quantile(colours, 0.1) < kBlue, rises = level_at(4.0) - level_at(25.0) > kRise;
  if (std::getenv("OWN_DEBUG")) std::printf("  ring %.2f of %.0f blue %.2f rise %.2f\n", ring.value(), ring.all, double(quantile(colours, 0.1)), double(level_at(4.0) - level_at(25.0)));
  if (blue || rises) own.uncovered_sun = std::clamp((ring.value() - 0.6) / 0.35, 0.0, 1.0);
  return own;
}

}  // namespace kasumi
