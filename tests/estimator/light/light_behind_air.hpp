// A surface behind air, as the spectral atmosphere has it and as the program makes it of what it knows of the air.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/geometry.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/light/airlight.hpp"
#include "estimator/light/object_light.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"

namespace kasumi::test {

inline const Direction kUp{0.0, 0.0, 1.0};
constexpr double kAlbedo = 0.3;  // of the surfaces looked at, grey

inline Direction at(double elevation_deg, double azimuth_deg) {
  return direction_from(from_degrees(90.0 - elevation_deg), from_degrees(azimuth_deg));
}

// Light in linear sRGB, lux and cd/m2.
struct Budget {
  glm::dvec3 sun{0};      // on a plane facing it
  glm::dvec3 sky{0};      // on level ground
  glm::dvec3 wall{0};     // sky and ground on the wall that faces the observer, without the sun
  glm::dvec3 horizon{0};  // radiance 1 deg high, where the observer looks
};

class Truth {
 public:
  Truth(const Aerosol& aerosol, double sun_deg, double ground_albedo = 0.2)
      : Truth(reference::optics_of({.aerosol = aerosol, .ground_albedo = ground_albedo}), sun_deg) {}
  Truth(reference::Optics optics, double sun_deg)
      : sun_(at(sun_deg, 0.0)), sky_(std::move(optics), reference::suns_around_deg(90.0 - sun_deg)) {}
  const Direction& sun() const { return sun_; }

  glm::dvec3 srgb(const std::vector<double>& light) const { return to_srgb_ * sky_.xyz_of(light); }
  glm::dvec3 light(const Direction& view) const { return srgb(sky_.radiance({0.0, view, sun_})); }
  Budget budget(const Direction& view) const {
    Budget found;
    const auto beam = sky_.sun_transmission(0.0, sun_.z);
    found.sun = srgb(beam);
    const auto ground = global();
    std::vector<double> sky = ground;
    for (std::size_t w = 0; w < sky.size(); ++w) sky[w] -= sun_.z * beam[w];
    found.sky = srgb(sky);
    found.wall = srgb(on_wall(view));
    found.horizon = light(at(1.0, to_degrees(azimuth_angle(view))));
    return found;
  }
  // A grey surface at a distance, as it is seen: level or the wall that faces the observer.
  glm::dvec3 seen(const Direction& view, double distance_m, bool wall) const {
    auto on_it = wall ? on_wall(view) : global();
    if (wall) {
      const auto beam = sky_.sun_transmission(0.0, sun_.z);
      for (std::size_t w = 0; w < beam.size(); ++w) on_it[w] += beam[w] * std::max(0.0, -dot(view, sun_));
    }
    const auto path = sky_.along({2.0, view, sun_}, distance_m);
    std::vector<double> light(on_it.size());
    for (std::size_t w = 0; w < light.size(); ++w)
      light[w] = path.light[w] + path.transmission[w] * kAlbedo / kPi * on_it[w];
    return srgb(light);
  }
  glm::dvec3 gamma(const Direction& view, double distance_m) const {
    const auto path = sky_.along({2.0, view, sun_}, distance_m);
    return srgb(path.transmission) / srgb(std::vector<double>(path.transmission.size(), 1.0));
  }

 private:
  std::vector<double> global() const {
    std::vector<double> ground(sky_.optics().size());
    for (std::size_t w = 0; w < ground.size(); ++w)
      ground[w] = sky_.diffuse().ground_flux(to_degrees(zenith_angle(sun_)), w);
    return ground;
  }
  // Half the sky and half the ground, of albedo .2.
  std::vector<double> on_wall(const Direction& view) const {
    const Direction normal = glm::normalize(Direction{-view.x, -view.y, 0.0});
    constexpr int kRings = 9, kSectors = 18;
    std::vector<double> light = global();
    for (double& l : light) l *= 0.5 * sky_.optics().ground_albedo;
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kSectors; ++j) {
        // Even in the sine of the elevation: equal solid angles.
        const double z = (i + 0.5) / kRings, phi = (j + 0.5) * 2.0 * kPi / kSectors;
        const Direction d{std::sqrt(1.0 - z * z) * std::sin(phi), std::sqrt(1.0 - z * z) * std::cos(phi), z};
        if (dot(d, normal) <= 0.0) continue;
        const auto radiance = sky_.radiance({0.0, d, sun_}, reference::Scattering::all, 3.0);
        for (std::size_t w = 0; w < light.size(); ++w)
          light[w] += radiance[w] * dot(d, normal) * 2.0 * kPi / (kRings * kSectors);
      }
    return light;
  }
  static double dot(const Direction& a, const Direction& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

  SunDirection sun_;
  reference::ReferenceSky sky_;
  glm::dmat3 to_srgb_ = xyz_to_linear_srgb();
};

inline Camera srgb_camera() {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  return camera;
}

// What the program makes of the same air.
class Estimated {
 public:
  Estimated(const AirState& air, double sun_deg, double ground_albedo = 0.2)
      : air_(air),
        sun_(at(sun_deg, 0.0)),
        model_(air.aerosol_known() ? ScatteringModel::aerosol : ScatteringModel::morales2017),
        sky_(DaylightModel::automatic, air, sun_, 0.0),
        daylight_(camera_, air, sun_, {.ground_albedo = ground_albedo}) {}

  Budget budget(const Direction& view) const {
    Budget found;
    found.sun = kLuminousEfficacy * daylight_.on_object().sun_irradiance;
    found.sky = kLuminousEfficacy * irradiance(daylight_.on_object().around, kUp);
    found.wall = kLuminousEfficacy * irradiance(daylight_.on_object().around, normal(view));
    found.horizon = kLuminousEfficacy * daylight_.airlight(at(1.0, to_degrees(azimuth_angle(view))));
    return found;
  }
  // Given the light that the camera measures at the horizon, 2 deg high.
  glm::dvec3 seen(const Direction& view, double distance_m, bool wall, const glm::dvec3& measured,
                  const glm::dvec3* true_gamma) const {
    const Direction horizon = at(2.0, to_degrees(azimuth_angle(view)));
    const glm::dvec3 infinity = measured * zeta(ZetaForm::full, sky_, view, horizon, xyz_to_linear_srgb());
    const auto& light = daylight_.on_object();
    const Direction faces = wall ? normal(view) : kUp;
    const glm::dvec3 falls =
        irradiance(light.around, faces) + std::max(0.0, glm::dot(faces, sun_)) * light.sun_irradiance;
    const glm::dvec3 rho = kAlbedo / kPi * falls / daylight_.airlight(view);
    const glm::dvec3 gamma = true_gamma ? *true_gamma : this->gamma(distance_m);
    return infinity * (rho * gamma + 1.0 - gamma);
  }
  glm::dvec3 gamma(double distance_m) const {
    const auto measure = spectral_measure(camera_);
    return attenuation(haze_coefficients(attenuation_nodes(measure, model_, air_), model_, air_),
                       optical_path(2.0, 2.0, distance_m));
  }

 private:
  static Direction normal(const Direction& view) { return glm::normalize(Direction{-view.x, -view.y, 0.0}); }

  Camera camera_ = srgb_camera();
  AirState air_;
  SunDirection sun_;
  ScatteringModel model_;
  SiteSky sky_;
  Daylight daylight_;
};

inline std::string text_of(const glm::dvec3& v) {
  return fmt::format("{:5.2f} {:5.2f} {:5.2f}", v.r, v.g, v.b);
}

// Steps of 255 where the horizon's green is exposed to half of full scale.
inline double steps(const glm::dvec3& found, const glm::dvec3& truth, double horizon_green) {
  const double scale = 0.5 / horizon_green;
  double sum = 0.0;
  const auto a = Response::srgb().to_encoded(glm::min(scale * found, 1.0)),
             b = Response::srgb().to_encoded(glm::min(scale * truth, 1.0));
  for (int c = 0; c < 3; ++c) sum += 255.0 * std::abs(a[c] - b[c]) / 3.0;
  return sum;
}

}  // namespace kasumi::test
