// The light on the virtual object from the same sky as its airlight, in absolute units, so that rho = L0 / Linf does
// not depend on the camera's exposure and white balance (physics 6).
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/sky/light_around.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/light/clear_sky_light.hpp"
#include "estimator/sky/ground_glow.hpp"
#include "estimator/sky/site_sky.hpp"
#include "estimator/turbidity/measured_sky.hpp"

namespace kasumi {

// Light in the scene camera's channels: the integral of W m-2 nm-1 (sr-1) times q_c when its colour space is sensor;
// when it is srgb, the same mixed into linear sRGB as the camera does it (exact for daylight; white of 683 lm is 1).
struct LightOnObject {
  SunDirection sun_direction{0, 0, 1};
  glm::dvec3 sun_irradiance{0};        // on a surface facing the sun; zero when the sun is hidden
  LightAround around;                  // sky and ground, without the sun's disc
  glm::dmat3 albedo_to_channels{1.0};  // of a surface with a given linear sRGB colour
};

struct DaylightConditions {
  SkyCondition sky = SkyCondition::clear;  // overcast: no sun, the CIE overcast sky
  double ground_albedo = 0.2;
  double altitude_m = 0.0;
  DaylightModel model = DaylightModel::automatic;
  // The sky camera's measurement of a cloudy sky, or null: where it sees clouds, they light the object instead of the
  // model, and they dim the sun. Only read in the constructor.
  const MeasuredSky* measured = nullptr;
  double past_hills = 1.0;  // the share of the sun's disc that hills leave to the object (Skyline)
};

// Sun, sky and ground for one air and sun position. Construction costs some milliseconds.
class Daylight {
 public:
  Daylight(const Camera& scene, const AirState& air, const SunDirection& sun, const DaylightConditions& options = {});

  const LightOnObject& on_object() const { return light_; }
  // The model's sky radiance in a direction; at or below the horizon that of the horizon. Always > 0.
  glm::dvec3 airlight(const Direction& direction) const;

  // For people and for tests.
  double sun_normal_lux() const { return sun_normal_lux_; }          // on a surface facing the sun
  double sky_horizontal_lux() const { return sky_horizontal_lux_; }  // diffuse, on the ground

 private:
  bool is_overcast() const { return options_.sky == SkyCondition::overcast; }
  double zenith_luminance() const;                       // cd m-2, of the model
  glm::dvec3 sky_xyz(const Direction& direction) const;  // the same in any direction
  // The model's light, replaced by the measured light where clouds are seen or, if overcast, wherever the camera looks.
  // `unit`: unit_of() the measured sky; empty: nothing is measured.
  glm::dvec3 seen_xyz(const Direction& direction, const std::optional<glm::dvec3>& unit) const;
  glm::dvec3 light_of(const glm::dvec3& xyz) const;
  // Factor from the camera's XYZ to the model's cd m-2, from the cells where both see the same; empty when they are
  // too few. It includes the sky camera's exposure and white balance.
  std::optional<glm::dvec3> unit_of(const MeasuredSky& measured) const;
  void glow_by_ground(const Aerosol& aerosol);  // before anything else reads the sky
  void light_by_sun(const SpectralSensitivity& sensor, const glm::dmat3& sensor_to_light, double reaching);
  void light_by_sky(const std::optional<glm::dvec3>& unit);
  void light_by_ground();  // after sun and sky, whose light it reflects

  DaylightConditions options_;
  SunDirection sun_;
  Turbidity turbidity_;  // clamped to the models' range
  SiteSky model_;
  double zenith_cd_m2_ = 0.0;
  std::optional<GroundGlow> glow_;  // where the dome has a share, over ground of another albedo than its own
  glm::dmat3 xyz_to_light_{1.0};
  LightOnObject light_;
  double sun_normal_lux_ = 0.0;
  double sky_horizontal_lux_ = 0.0;
};

}  // namespace kasumi
