#include "estimator/photograph/other_air.hpp"

#include <cmath>

#include <glm/common.hpp>

#include "base/geometry.hpp"
#include "base/picture.hpp"
#include "estimator/light/object_light.hpp"
#include "estimator/photograph/depth_from_haze.hpp"
#include "estimator/photograph/land_around.hpp"
#include "estimator/photograph/picture_noise.hpp"

namespace kasumi {
namespace {

Image<glm::vec3> light_of(const Camera& camera, const Image<glm::vec3>& encoded) {
  Image<glm::vec3> light(encoded.width(), encoded.height());
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) light.at(x, y) = camera.light_at({x, y}, glm::dvec3(encoded.at(x, y)));
  return light;
}

Image<glm::vec3> encoded_of(const Camera& camera, const Image<glm::vec3>& light) {
  Image<glm::vec3> encoded(light.width(), light.height());
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const auto seen = glm::dvec3(light.at(x, y)) * camera.white_balance * camera.vignetting.at({x, y});
      encoded.at(x, y) = glm::clamp(camera.response.to_encoded(seen), 0.0, 1.0);
    }
  return encoded;
}

}  // namespace

Camera plain_camera(int width, int height, Radians field_of_view, Radians pitch) {
  Camera camera;
  camera.name = "photograph";
  camera.width = width;
  camera.height = height;
  const double focal_px = 0.5 * width / std::tan(0.5 * field_of_view.value);
  camera.lens = pinhole_lens({{focal_px, focal_px}, {0.5 * (width - 1), 0.5 * (height - 1)}, {}});
  camera.to_world = camera_to_world(Radians{0.0}, pitch, Radians{0.0});
  camera.vignetting.centre = {0.5 * (width - 1), 0.5 * (height - 1)};
  return camera;
}

Result<HorizonLight> horizon_of(const Camera& camera, const Photograph& photograph, const std::string& name) {
  const auto pixels = to_rgb8(photograph);
  auto horizon = measure_horizon(camera, view_of(pixels));
  if (!horizon.usable())
    return fail(FaultKind::bad_input,
                "{}: no horizon to measure the light from infinity ({}): expected a picture with some sky above the "
                "land, or --airlight R,G,B",
                name, horizon.reason);
  return horizon;
}

OtherAir::OtherAir(SourceConditions options)
    : options_(std::move(options)),
      scattering_(options_.scattering.value_or(options_.source.aerosol_known() ? ScatteringModel::aerosol
                                                                               : ScatteringModel::morales2017)),
      nodes_(options_.from_haze && options_.grey_from_haze
                 ? grey_attenuation_nodes()
                 : attenuation_nodes(spectral_measure(options_.camera), scattering_, options_.source)),
      rise_(rise_of(options_.camera)) {}

Result<> OtherAir::set_picture(Photograph photograph, const std::string& name) {
  const auto& camera = options_.camera;
  const auto& encoded = photograph.encoded;
  if (encoded.width() != camera.width || encoded.height() != camera.height)
    return fail(FaultKind::bad_input,
                "{}: is {} x {}: expected {} x {}, the size of its camera or of the first picture", name,
                encoded.width(), encoded.height(), camera.width, camera.height);
  quantum_ = photograph.quantum;
  if (options_.from_haze) {
    guess_from_haze(photograph);
    separate(photograph);
    return {};
  }
  if (!options_.airlight) {
    auto found = horizon_of(camera, photograph, name);
    // In a film, a picture in which no horizon is found uses that of the pictures before it.
    if (!found && (!horizon_ || options_.horizon_weight >= 1.0)) return fail(found.error());
    if (found && horizon_ && options_.horizon_weight < 1.0)
      horizon_ = blend(*horizon_, *found, options_.horizon_weight);
    else if (found)
      horizon_ = std::move(*found);
  }
  depth_ = {options_.distance_m, rise_, options_.altitude_m};
  if (options_.distance_m.empty())
    depth_.distance_m =
        Image<float>(camera.width, camera.height, static_cast<float>(options_.everything_at_m.value_or(1000.0)));
  if (options_.distance_m.empty() || options_.find_sky) {
    const auto parts = segment_sky(to_rgb8(photograph));
    for (int y = 0; parts.visible && y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        if (parts.sky.at(x, y) != 0) depth_.distance_m.at(x, y) = 0.0F;
  }
  light_ = light_of(camera, encoded);
  source_ = {options_.source, from_infinity(options_.airlight, horizon_ ? &*horizon_ : nullptr, options_.source)};
  separate(photograph);
  return {};
}

void OtherAir::separate(const Photograph& photograph) {
  parts_ = {};
  if (!options_.amplify_noise)
    if (const auto noise = noise_of(photograph.encoded); noise != glm::dvec3{0.0})
      parts_.clean = light_of(options_.camera, without_noise(photograph.encoded, noise));
  if (options_.relight && options_.sun)
    parts_.land_around = land_around(light_, depth_, source_, nodes_, {.scattering = scattering_});
}

void OtherAir::guess_from_haze(const Photograph& photograph) {
  const auto sky = segment_sky(to_rgb8(photograph));
  light_ = light_of(options_.camera, photograph.encoded);
  source_.state = options_.source;
  if (options_.airlight)
    source_.from_infinity = Image<glm::vec3>(light_.width(), light_.height(), glm::vec3(*options_.airlight));
  else
    source_.from_infinity = light_of_haze(light_, photograph.encoded, sky.visible ? sky.sky : Image<std::uint8_t>{});
  auto relative = light_;
  for (std::size_t i = 0; i < relative.elements().size(); ++i)
    relative.elements()[i] /= source_.from_infinity.elements()[i];
  // Paths at sea level, since only their optical depth matters.
  depth_ = {depth_from_haze(relative, photograph.encoded, nodes_, scattering_, options_.source), {}, 0.0};
}

Image<glm::vec3> OtherAir::from_infinity(const std::optional<glm::dvec3>& given, const HorizonLight* horizon,
                                         const AirState& air) const {
  const auto& camera = options_.camera;
  if (given) return {1, 1, glm::vec3(*given)};
  if (options_.sun) {
    const SiteSky sky(sky_model_of(air), air, *options_.sun, options_.altitude_m);
    return light_from_infinity(camera, Airlight(*horizon, sky, camera.light_to_xyz()));
  }
  // The sun's position is unknown: the horizon's light is used for all elevations.
  Image<glm::vec3> light(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y}))
        light.at(x, y) = column_at(*horizon, azimuth_angle(*direction)).light;
  return light;
}

Image<glm::vec3> OtherAir::targets(const std::optional<AirState>& target) const {
  const AirState air = target.value_or(clearest_like(options_.source));
  if (options_.target_airlight || options_.target_horizon)
    return from_infinity(options_.target_airlight, options_.target_horizon ? &*options_.target_horizon : nullptr, air);
  auto light = source_.from_infinity;
  if (!options_.sun || air == options_.source) return light;
  const auto& camera = options_.camera;
  DaylightConditions daylight;
  daylight.altitude_m = options_.altitude_m;
  const auto daylight_under = [&](const AirState& state) {
    daylight.model = sky_model_of(state);  // as for the airlight and the light on the land
    return Daylight(camera, state, *options_.sun, daylight);
  };
  const Daylight before = daylight_under(options_.source), after = daylight_under(air);
  double exposure = 1.0;
  if (const auto middle = camera.direction_at({0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
      middle && !options_.same_exposure) {
    const auto towards = raised_to_horizon(*middle);
    exposure = before.airlight(towards).g / after.airlight(towards).g;
  }
  if (light.width() == 1) light = Image<glm::vec3>(camera.width, camera.height, light.at(0, 0));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y}))
        light.at(x, y) *= glm::vec3(exposure * after.airlight(*direction) / before.airlight(*direction));
  return light;
}

UnderOtherAir OtherAir::under(const std::optional<AirState>& target) const {
  const auto& camera = options_.camera;
  RetargetLimits retargeting;
  retargeting.scattering = scattering_;
  retargeting.largest_gain = options_.largest_gain;
  retargeting.terms = options_.terms;
  const auto middle = camera.direction_at({0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
  if (options_.relight && options_.sun && middle)
    retargeting.relit = relighting(camera, options_.source, target, *options_.sun, *middle, options_.altitude_m);
  auto made = retarget(light_, depth_, source_, {target, targets(target)}, nodes_, retargeting, parts_);
  UnderOtherAir found;
  found.picture.encoded = encoded_of(camera, made.light);
  found.picture.quantum = quantum_;
  found.restored = std::move(made.restored);
  found.too_faint_fraction = made.too_faint_fraction;
  if (!options_.terms) return found;
  constexpr double kFine = 1.0 / 65535.0;  // of 16 bits, so that sums of parts do not show steps of 8 bits
  auto direct = std::move(made.light);
  for (std::size_t i = 0; i < direct.elements().size(); ++i) direct.elements()[i] -= made.airlight.elements()[i];
  found.airlight = Photograph{encoded_of(camera, made.airlight), {}, kFine, {}};
  found.direct = Photograph{encoded_of(camera, direct), {}, kFine, {}};
  return found;
}

}  // namespace kasumi
