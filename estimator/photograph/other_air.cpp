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

OtherAir::OtherAir(OtherAirSetup setup)
    : setup_(std::move(setup)),
      nodes_(setup_.from_haze ? grey_attenuation_nodes() : attenuation_nodes(spectral_measure(setup_.camera))),
      rise_(rise_of(setup_.camera)) {}

Result<> OtherAir::take(Photograph photograph, const std::string& name) {
  const auto& camera = setup_.camera;
  const auto& encoded = photograph.encoded;
  if (encoded.width() != camera.width || encoded.height() != camera.height)
    return fail(FaultKind::bad_input,
                "{}: is {} x {}: expected {} x {}, the size of its camera or of the first picture", name,
                encoded.width(), encoded.height(), camera.width, camera.height);
  quantum_ = photograph.quantum;
  if (setup_.from_haze) {
    guess_from_haze(photograph);
    part(photograph);
    return {};
  }
  if (!setup_.airlight) {
    auto found = horizon_of(camera, photograph, name);
    // In a film, a picture in which no horizon is found uses that of the pictures before it.
    if (!found && (!horizon_ || setup_.horizon_weight >= 1.0)) return fail(found.error());
    if (found && horizon_ && setup_.horizon_weight < 1.0)
      horizon_ = blend(*horizon_, *found, setup_.horizon_weight);
    else if (found)
      horizon_ = std::move(*found);
  }
  depth_ = {setup_.distance_m, rise_, setup_.altitude_m};
  if (setup_.distance_m.empty())
    depth_.distance_m =
        Image<float>(camera.width, camera.height, static_cast<float>(setup_.everything_at_m.value_or(1000.0)));
  if (setup_.distance_m.empty() || setup_.find_sky) {
    const auto parts = segment_sky(to_rgb8(photograph));
    for (int y = 0; parts.visible && y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        if (parts.sky.at(x, y) != 0) depth_.distance_m.at(x, y) = 0.0F;
  }
  light_ = light_of(camera, encoded);
  source_ = {setup_.source, from_infinity(setup_.airlight, horizon_ ? &*horizon_ : nullptr, setup_.source)};
  part(photograph);
  return {};
}

void OtherAir::part(const Photograph& photograph) {
  parts_ = {};
  if (!setup_.amplify_noise)
    if (const auto noise = noise_of(photograph.encoded); noise != glm::dvec3{0.0})
      parts_.clean = light_of(setup_.camera, without_noise(photograph.encoded, noise));
  if (setup_.relight && setup_.sun)
    parts_.land_around = land_around(light_, depth_, source_, nodes_, {.scattering = setup_.scattering});
}

void OtherAir::guess_from_haze(const Photograph& photograph) {
  const auto sky = segment_sky(to_rgb8(photograph));
  light_ = light_of(setup_.camera, photograph.encoded);
  source_.turbidity = setup_.source;
  if (setup_.airlight)
    source_.from_infinity = Image<glm::vec3>(light_.width(), light_.height(), glm::vec3(*setup_.airlight));
  else
    source_.from_infinity = light_of_haze(light_, photograph.encoded, sky.visible ? sky.sky : Image<std::uint8_t>{});
  auto relative = light_;
  for (std::size_t i = 0; i < relative.elements().size(); ++i)
    relative.elements()[i] /= source_.from_infinity.elements()[i];
  // Paths at sea level, since only their optical depth matters.
  depth_ = {depth_from_haze(relative, photograph.encoded, nodes_, setup_.scattering, setup_.source), {}, 0.0};
}

Image<glm::vec3> OtherAir::from_infinity(const std::optional<glm::dvec3>& given, const HorizonLight* horizon,
                                         Turbidity turbidity) const {
  const auto& camera = setup_.camera;
  if (given) return {1, 1, glm::vec3(*given)};
  if (setup_.sun) return light_from_infinity(camera, Airlight(*horizon, turbidity, *setup_.sun, camera.light_to_xyz()));
  // The sun's position is unknown: the horizon's light is used for all elevations.
  Image<glm::vec3> light(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y}))
        light.at(x, y) = column_at(*horizon, azimuth_angle(*direction)).light;
  return light;
}

Image<glm::vec3> OtherAir::targets(const std::optional<Turbidity>& target) const {
  const Turbidity turbidity = target.value_or(kLowestTurbidity);
  if (setup_.target_airlight || setup_.target_horizon)
    return from_infinity(setup_.target_airlight, setup_.target_horizon ? &*setup_.target_horizon : nullptr, turbidity);
  auto light = source_.from_infinity;
  if (!setup_.sun || turbidity == setup_.source) return light;
  const auto& camera = setup_.camera;
  DaylightOptions options;
  options.altitude_m = setup_.altitude_m;
  options.model = SiteSkyModel::preetham;  // as for the airlight and the light on the land
  const Daylight before(camera, setup_.source, *setup_.sun, options), after(camera, turbidity, *setup_.sun, options);
  double exposure = 1.0;
  if (const auto middle = camera.direction_at({0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
      middle && !setup_.same_exposure) {
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

UnderOtherAir OtherAir::under(const std::optional<Turbidity>& target) const {
  const auto& camera = setup_.camera;
  RetargetOptions options;
  options.scattering = setup_.scattering;
  options.largest_gain = setup_.largest_gain;
  const auto middle = camera.direction_at({0.5 * (camera.width - 1), 0.5 * (camera.height - 1)});
  if (setup_.relight && setup_.sun && middle)
    options.relit = relighting(camera, setup_.source, target, *setup_.sun, *middle, setup_.altitude_m);
  auto made = retarget(light_, depth_, source_, {target, targets(target)}, nodes_, options, parts_);
  UnderOtherAir found;
  found.picture.encoded = encoded_of(camera, made.light);
  found.picture.quantum = quantum_;
  found.restored = std::move(made.restored);
  found.too_faint_fraction = made.too_faint_fraction;
  return found;
}

}  // namespace kasumi
