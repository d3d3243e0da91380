#include "estimator/turbidity/picture_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "calib/colour/colorimetry.hpp"

namespace kasumi {

namespace {

// Next to the sun the lens scatters what is no sky's light; relative standard deviation at the sun, none from there on.
constexpr double kGlareDoubt = 0.2;
// From the sun: nearer, a lens's glare adds to the sky's light.
constexpr Radians kGlareEnds = from_degrees(10.0);

// Distance from the optical axis in the picture, 1 where the lens ends.
class OffAxis {
 public:
  OffAxis(const Camera& camera, const SkyPicture& picture, const ElementGeometry& geometry)
      : picture_(picture),
        centre_(camera.lens->project({0.0, 0.0, 1.0}).value_or(0.5 * glm::dvec2{camera.width - 1, camera.height - 1})),
        radius_px_(geometry.rim_px) {}
  double at(const glm::ivec2& e) const { return glm::distance(picture_.camera_pixel(e.x, e.y), centre_) / radius_px_; }

 private:
  const SkyPicture& picture_;
  glm::dvec2 centre_;
  double radius_px_;
};

}  // namespace

ElementReadings readings_at(std::span<const glm::ivec2> elements, const SkyPicture& picture,
                            const ElementGeometry& geometry, const ElementLight& sky, const Camera& camera,
                            const SunDirection& sun, const SampleLimits& limits) {
  const OffAxis off_axis(camera, picture, geometry);
  const glm::dmat3 to_srgb = xyz_to_linear_srgb() * geometry.light_to_xyz;
  ElementReadings found;
  for (const glm::ivec2& e : elements) {
    glm::dvec3 light{0.0}, variance{0.0}, coarse{0.0};
    int count = 0;
    for (int y = e.y - 1; y <= e.y + 1; ++y)
      for (int x = e.x - 1; x <= e.x + 1; ++x) {
        if (!sky.use.contains(x, y) || sky.use.at(x, y) != PixelUse::clear) continue;
        const glm::dvec3 encoded(picture.encoded.at(x, y)), gain(geometry.gain.at(x, y));
        light += glm::dvec3(sky.light.at(x, y));
        const glm::dvec3 photons = gain * limits.shot_noise * glm::sqrt(camera.response.to_light(encoded));
        const glm::dvec3 step = gain * camera.response.slope(encoded) * picture.quantum / std::sqrt(12.0);
        variance += photons * photons;
        coarse += step * step;
        ++count;
      }
    if (count == 0) continue;
    light /= count;
    // Neighbours in a smooth sky are rounded alike: three of nine count.
    variance = variance / double{1.0 * count * count} + coarse / (count * std::max(1.0, count / 3.0));
    SkyReading reading;
    reading.direction = glm::normalize(glm::dvec3(geometry.direction.at(e.x, e.y)));
    reading.light = to_srgb * light;
    if (!(std::min({reading.light.r, reading.light.g, reading.light.b}) > 0.0)) continue;
    const double from_sun = angle_between(reading.direction, sun).value / kGlareEnds.value;
    const double glare = kGlareDoubt * std::max(0.0, 1.0 - from_sun);
    for (int c = 0; c < 3; ++c) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k) sum += to_srgb[k][c] * to_srgb[k][c] * variance[k];
      reading.sigma[c] = std::hypot(std::sqrt(sum) / reading.light[c], glare);
    }
    reading.off_axis = off_axis.at(e);
    found.readings.push_back(reading);
    found.elements.push_back(e);
  }
  return found;
}

InstrumentDoubt doubt_of(const Camera& camera) {
  // 1 sigma of ln: by calibration 2 %; 10 % for any camera's white balance, 15 % for any lens's rim loss.
  constexpr double kMeasuredColours = 0.02, kAnyColours = 0.1, kMeasuredLens = 0.02, kAnyLens = 0.15;
  const bool colours_measured =
      camera.colour_space == Camera::ColourSpace::sensor && camera.sensitivity.name != generic_sensitivity().name;
  const bool lens_measured = std::ranges::any_of(camera.vignetting.coefficients, [](double v) { return v != 0.0; });
  InstrumentDoubt doubt;
  doubt.white_balance = colours_measured ? kMeasuredColours : kAnyColours;
  doubt.vignetting = lens_measured ? kMeasuredLens : kAnyLens;
  return doubt;
}

}  // namespace kasumi
