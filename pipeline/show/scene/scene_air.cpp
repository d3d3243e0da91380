#include "pipeline/show/scene/scene_air.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/earth.hpp"
#include "calib/colour/camera_saturation.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/light/finite_path.hpp"
#include "gles/light/airlight_grid.hpp"
#include "pipeline/show/scene/for_gles.hpp"
#include "pipeline/show/scene/light_behind.hpp"

namespace kasumi {

namespace {

// Clouds and people pass while the air stays, so the horizon is smoothed with this time constant. A horizon from before
// a long outage has no weight.
constexpr Turbidity kClearAir{2.0};  // a clear day in the mountains
constexpr double kHorizonMemory_s = 2.8;
constexpr double kCardsMemory_s = 180.0;      // a person leans on the wall; clouds' light is computed a moment late
constexpr double kCardsForgotten_s = 1800.0;  // unread for so long: their factors are of another light
constexpr double kBehindMemory_s = 60.0;      // a person walks through the fog before the camera

// Smaller steps are invisible: half a percent of the haze, a tenth of a degree of the sun.
constexpr double kMinHazeChange = 0.005;
constexpr double kMinExponentChange = 0.02;  // half a percent of haze, between green and blue
constexpr double kMinShareChange = 0.1;      // of the kind beside the first
constexpr Radians kMinSunMove = from_degrees(0.1);
constexpr double kMinLightChange = 0.02;
constexpr double kMinSkyChange = 0.03;  // of the sun's share, of a quarter of the sky

std::optional<double> exposure_of(const FrameMetadata& metadata) {
  if (!metadata.exposure_s || *metadata.exposure_s <= 0) return std::nullopt;
  return *metadata.exposure_s * metadata.gain.value_or(1.0);
}

// Weight of a frame against the estimate at `last`, which fades with a time constant.
double weight_after(const std::optional<Instant>& last, const FrameMetadata& metadata, double memory_s) {
  return last ? 1.0 - std::exp(-std::abs(to_seconds(metadata.captured_at - *last)) / memory_s) : 1.0;
}

void scale(HorizonLight& horizon, double factor) {
  for (auto& column : horizon.columns) column.light *= factor;
}

// Light from infinity times this gives M's (1 - Gamma) Linf the light that the air before the object truly adds.
class AirBeforeObject {
 public:
  AirBeforeObject(const FinitePath& paths, const HazeCoefficients& haze, double altitude_m, double distance_m)
      : paths_(paths), haze_(haze), altitude_m_(altitude_m), distance_m_(distance_m) {}

  glm::dvec3 factor(const Direction& direction) const {
    const double level = std::max(std::hypot(direction.x, direction.y), 1e-3), length_m = distance_m_ / level;
    const double rise_m = length_m * direction.z + distance_m_ * distance_m_ / (2.0 * kEarthRadius_m);
    return paths_.factor(direction, rise_m,
                         attenuation(haze_, optical_path(altitude_m_, altitude_m_ + rise_m, length_m)));
  }

 private:
  FinitePath paths_;
  HazeCoefficients haze_;
  double altitude_m_, distance_m_;
};

// Nearly to zero; zero itself would leave the renderer without a scale.
void darken(ObjectLight& light) {
  constexpr double kBlack = 1e-6;  // nearly no light, and no division by zero
  light.sun_irradiance *= kBlack;
  for (glm::vec3& texel : light.around.radiance.elements()) texel *= static_cast<float>(kBlack);
}

void follow_cards(ObjectLight& light, const LightFactors& by_cards) {
  if (by_cards.sun == glm::dvec3{1.0} && by_cards.around == glm::dvec3{1.0}) return;
  light.sun_irradiance *= by_cards.sun;
  for (glm::vec3& texel : light.around.radiance.elements()) texel *= glm::vec3(by_cards.around);
}

OpticalPath path_to(const Installation& installation) {
  const auto& place = installation.object.placement;
  const double altitude_m = installation.site.altitude_m;
  return optical_path(altitude_m, altitude_m + place.up_m, std::hypot(place.east_m, place.north_m, place.up_m));
}

// The horizon as it would be without the camera's saturation, which comes behind its white balance.
HorizonLight unsaturated(HorizonLight horizon, const glm::dvec3& white_balance, double saturation) {
  constexpr double kLeast = 1e-3;  // of a colour that no camera of less than 1 can have saturated so far
  for (auto& column : horizon.columns) {
    const glm::dvec3 seen = column.light * white_balance;
    column.light = glm::max(with_saturation(seen, 1.0 / saturation), kLeast * seen) / white_balance;
  }
  return horizon;
}

}  // namespace

bool look_alike(const SceneConditions& now, const SceneConditions& drawn) {
  if (now.view != drawn.view) return false;
  for (int c = 0; c < 3; ++c)
    if (std::abs(now.by_cards.sun[c] - drawn.by_cards.sun[c]) > kMinLightChange ||
        std::abs(now.by_cards.around[c] - drawn.by_cards.around[c]) > kMinLightChange)
      return false;
  if (now.sky != drawn.sky || (now.measured == nullptr) != (drawn.measured == nullptr)) return false;
  if (now.measured && difference(*drawn.measured, *now.measured) > kMinSkyChange) return false;
  if (std::abs(now.past_hills - drawn.past_hills) > kMinSkyChange) return false;
  if (std::abs(now.air.near_ground() - drawn.air.near_ground()) > kMinHazeChange * drawn.air.near_ground())
    return false;
  if (now.air.aerosol_known() || drawn.air.aerosol_known()) {
    const Aerosol &aerosol = now.air.aerosol(), &aerosol_drawn = drawn.air.aerosol();
    return now.air.aerosol_known() == drawn.air.aerosol_known() && aerosol.kind == aerosol_drawn.kind &&
           aerosol.other == aerosol_drawn.other &&
           std::abs(aerosol.other_share - aerosol_drawn.other_share) <= kMinShareChange &&
           std::abs(aerosol.angstrom_exponent - aerosol_drawn.angstrom_exponent) <= kMinExponentChange &&
           std::abs(aerosol.aod_550 - aerosol_drawn.aod_550) <= kMinHazeChange * aerosol_drawn.aod_550 &&
           angle_between(now.sun, drawn.sun) <= kMinSunMove;
  }
  const double haze = now.air.turbidity().value - 1.0, haze_drawn = drawn.air.turbidity().value - 1.0;
  return std::abs(haze - haze_drawn) <= kMinHazeChange * haze_drawn && angle_between(now.sun, drawn.sun) <= kMinSunMove;
}

SceneAir::SceneAir(const Installation& installation, AirRendering options)
    : observer_(std::make_shared<const HorizonObserver>(
          installation.scene, installation.sky, installation.surroundings.sky_model, installation.site.altitude_m,
          installation.cards, installation.surroundings.ground_albedo)),
      altitude_m_(installation.site.altitude_m),
      ground_albedo_(installation.surroundings.ground_albedo),
      shadows_(installation.object.shadows),
      saturation_(installation.given_saturation()),
      skyline_(installation.object.skyline),
      sky_model_(installation.surroundings.sky_model),
      given_(installation.surroundings.air),
      fog_(installation.surroundings.fog),
      blur_of_depth_1_px_(installation.surroundings.haze_blur_px),
      to_object_(path_to(installation)),
      to_object_m_(std::hypot(installation.object.placement.east_m, installation.object.placement.north_m)),
      options_(options),
      measure_(spectral_measure(installation.scene)) {
  cards_.in_view = installation.cards.size();
}

AirState SceneAir::air_under(const SkyReport& report) const {
  if (options_.turbidity) return air_of(*options_.turbidity, given_.to_be_found());
  if (const auto given = given_.whole()) return *given;
  return report.air ? report.air->air : air_of(options_.until_known, given_.to_be_found());
}

ScatteringModel SceneAir::scattering(const AirState& air) const {
  if (options_.scattering) return *options_.scattering;
  const bool own = air.aerosol_known() && resolved(sky_model_, altitude_m_, true) == DaylightModel::dome;
  return own ? ScatteringModel::aerosol : ScatteringModel::morales2017;
}

HazeCoefficients SceneAir::haze(const AirState& air) const {
  const auto model = scattering(air);
  const double exponent = air.aerosol().angstrom_exponent;
  const bool same =
      nodes_ && nodes_->scattering == model &&
      (model != ScatteringModel::aerosol || std::abs(nodes_->angstrom_exponent - exponent) <= kMinExponentChange);
  if (!same) nodes_ = {model, exponent, attenuation_nodes(measure_, model, air)};
  return haze_coefficients(nodes_->nodes, model, air);
}

SceneConditions SceneAir::conditions(const SkyReport& report) const {
  SceneConditions conditions;
  conditions.air = air_under(report);
  conditions.sky = report.estimate.sky;
  if (report.sun.source != SunSource::none) conditions.sun = report.sun.direction;
  conditions.past_hills = skyline_.sunlight(conditions.sun);
  conditions.measured = report.measured;
  conditions.by_cards = cards_.factors;
  conditions.saturation = saturation_.value_or(report.scene_saturation.value_or(1.0));
  conditions.haze_blur_px = haze_blur_px(conditions.air);
  return conditions;
}

SceneConditions SceneAir::conditions(const SkyReport& report, BuildingView view) const {
  auto conditions = this->conditions(report);
  if (view == BuildingView::live || view == BuildingView::alone) return conditions;
  conditions.view = view;
  if (view == BuildingView::clear_air) {
    const auto& air = conditions.air;  // its kind stays
    conditions.air = air_of(kClearAir, air.aerosol_known() ? std::optional(air.aerosol()) : given_.to_be_found());
    conditions.haze_blur_px = haze_blur_px(conditions.air);
  }
  return conditions;
}

ObjectAppearance SceneAir::appearance(const SceneConditions& conditions, const PixelBox& box,
                                      const GroundLook& ground) const {
  const Daylight daylight(
      scene(), conditions.air, conditions.sun,
      {conditions.sky, ground_albedo_, altitude_m_, sky_model_, conditions.measured.get(), conditions.past_hills});
  ObjectAppearance appearance;
  appearance.haze = haze_for_gles(haze(conditions.air), altitude_m_, fog_);
  appearance.light = light_for_gles(daylight.on_object());
  follow_cards(appearance.light, conditions.by_cards);
  if (options_.black_object) darken(appearance.light);
  const auto before_object = air_before_object(conditions);
  appearance.horizon = airlight_grid(scene(), box, [&](const glm::dvec2&, const Direction& direction) {
    return daylight.airlight(direction) * before_object(direction);
  });
  appearance.aerial_perspective = options_.aerial_perspective;
  appearance.shadows = shadows_;
  light_ground(appearance, ground);
  return appearance;
}

double SceneAir::haze_blur_px(const AirState& air) const {
  if (blur_of_depth_1_px_ <= 0.0 || !options_.aerial_perspective) return 0.0;
  const double left = std::clamp(attenuation(haze(air), to_object_).g, 1e-9, 1.0);
  return blur_of_depth_1_px_ * std::sqrt(-std::log(left));
}

void SceneAir::follow_exposure(const FrameMetadata& metadata) {
  const auto exposure = exposure_of(metadata);
  if (exposure && exposure_) scale(horizon_, *exposure / *exposure_);
  exposure_ = exposure;
}

bool SceneAir::horizon_is_due(const FrameMetadata& metadata) const {
  const auto& last = horizon_asked_at_ ? horizon_asked_at_ : horizon_seen_at_;
  return !last || metadata.captured_at < *last || metadata.captured_at - *last >= options_.horizon_interval;
}

void SceneAir::adopt(const HorizonAnswer& answer) {
  if (answer.observer != observer_) return;
  auto seen = answer.seen;
  const auto then = exposure_of(answer.metadata);
  if (then && exposure_) scale(seen, *exposure_ / *then);  // the camera has moved on
  adopt(std::move(seen), answer.metadata);
  adopt(answer.cards, answer.metadata);
  adopt(answer.behind, answer.metadata);
}

void SceneAir::adopt(const std::vector<CardReading>& cards, const FrameMetadata& metadata) {
  cards_.read = cards.size();
  if (cards.empty() && !cards_followed_at_) return;
  const LightFactors now = factors_by_cards(cards);  // of none: the model's own
  const double weight = weight_after(cards_followed_at_, metadata, cards.empty() ? kCardsForgotten_s : kCardsMemory_s);
  cards_followed_at_ = metadata.captured_at;
  if (!cards.empty()) cards_.read_at = metadata.captured_at;
  LightFactors& factors = cards_.factors;
  factors = {glm::mix(factors.sun, now.sun, weight), glm::mix(factors.around, now.around, weight), now.sun_sigma,
             now.around_sigma};
}

std::optional<CardsLook> SceneAir::cards() const {
  return cards_.in_view == 0 ? std::nullopt : std::optional(cards_);
}

void SceneAir::adopt(const std::optional<AirlightGrid>& behind, const FrameMetadata& metadata) {
  if (!behind) return;
  const bool same = behind_ && behind_->first_px == behind->first_px && behind_->last_px == behind->last_px;
  const double weight = same ? weight_after(behind_seen_at_, metadata, kBehindMemory_s) : 1.0;
  behind_seen_at_ = metadata.captured_at;
  if (!same) behind_ = behind;
  for (std::size_t i = 0; i < behind->light.size(); ++i)
    behind_->light[i] = glm::mix(behind_->light[i], behind->light[i], weight);
}

void SceneAir::adopt(HorizonLight seen, const FrameMetadata& metadata) {
  const double weight = weight_after(horizon_seen_at_, metadata, kHorizonMemory_s);
  horizon_seen_at_ = metadata.captured_at;
  horizon_ = blend(horizon_, seen, horizon_.usable() ? weight : 1.0);
}

std::function<glm::dvec3(const Direction&)> SceneAir::air_before_object(const SceneConditions& conditions) const {
  // Under a closed sky, and in fog, the light comes from all sides.
  const bool even = conditions.sky == SkyCondition::overcast || fog_.extinction_per_m > 0.0;
  const SiteSky sky(sky_model_, conditions.air, conditions.sun, altitude_m_);
  if (even || sky.dome_share() <= 0.0) return [](const Direction&) { return glm::dvec3{1.0}; };
  const FinitePath paths(sky, conditions.air, conditions.sun, altitude_m_, glm::inverse(scene().light_to_xyz()));
  const AirBeforeObject air(paths, haze(conditions.air), altitude_m_, to_object_m_);
  return [air](const Direction& direction) { return air.factor(direction); };
}

glm::dvec3 SceneAir::most_before_object(const glm::dvec2& pixel, const HorizonLight& horizon,
                                        const Direction& direction, const glm::dvec3& left) const {
  if (!behind_) return glm::dvec3{std::numeric_limits<double>::infinity()};
  return most_airlight(airlight_at(*behind_, pixel) * column_at(horizon, azimuth_angle(direction)).light, left);
}

AirlightGrid SceneAir::measured(const SceneConditions& conditions, const PixelBox& box) const {
  const auto before_object = air_before_object(conditions);
  if (!horizon_.usable())
    return airlight_grid(scene(), box, [&](const glm::dvec2&, const Direction& direction) {
      return glm::dvec3{0.5} * before_object(direction);
    });
  const bool saturates = conditions.saturation != 1.0;
  const HorizonLight beyond =
      saturates ? unsaturated(horizon_, scene().white_balance, conditions.saturation) : horizon_;
  const Airlight airlight(beyond, SiteSky(sky_model_, conditions.air, conditions.sun, altitude_m_),
                          scene().light_to_xyz(), options_.zeta);
  const glm::dvec3 left = attenuation(haze(conditions.air), to_object_);
  auto grid = airlight_grid(scene(), box, [&](const glm::dvec2& pixel, const Direction& direction) {
    const glm::dvec3 light = glm::min(airlight.from(direction) * before_object(direction),
                                      most_before_object(pixel, beyond, direction, left));
    // Back into the camera's own linear light, in which its pixels are compared and blended.
    return light * scene().white_balance * scene().vignetting.at(pixel);
  });
  grid.saturation = conditions.saturation;
  return grid;
}

}  // namespace kasumi
