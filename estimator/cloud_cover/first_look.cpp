#include "estimator/cloud_cover/first_look.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "estimator/turbidity/colour_statistics.hpp"

namespace kasumi {

namespace {

// By how much each number must be on the refused side of its limit: means over 8 x 8 pixels are smoother and a little
// greyer than single ones.
constexpr double kShareMargin = 0.8, kSpreadMargin = 1.5, kSpanMargin = 1.25, kBluestMargin = 0.03;

// Around the sun's place something is brighter than the sky beside, its disc or where it shines through: by no more than
// what is left of a disc of 3 deg that four elements share.
bool sun_may_show(const SkyPicture& coarse, const ElementGeometry& geometry, const SunDirection& sun) {
  // The disc with its glare, and the sky just outside.
  constexpr Radians kNear = from_degrees(5.0), kBesideEnds = from_degrees(12.0);
  constexpr float kLeftOfDisc = 0.1f;  // of what is missing to white
  const auto near = static_cast<float>(std::cos(kNear.value)),
             beside_from = static_cast<float>(std::cos(kBesideEnds.value));
  const glm::vec3 towards_sun(sun);
  float brightest = 0.0f, beside = 0.0f;  // encoded, of the darkest channel
  int places = 0;
  for (std::size_t i = 0; i < geometry.open.elements().size(); ++i) {
    const float at = glm::dot(geometry.direction.elements()[i], towards_sun);
    if (at < beside_from || geometry.open.elements()[i] == 0) continue;
    const glm::vec3& e = coarse.encoded.elements()[i];
    const float level = std::min({e.r, e.g, e.b});
    if (at > near)
      brightest = std::max(brightest, level);
    else
      beside += level, ++places;
  }
  if (places == 0) return true;
  beside /= static_cast<float>(places);
  return brightest > beside + kLeftOfDisc * (1.0f - beside);
}

}  // namespace

std::optional<ClosedSky> FirstLook::refuse(const SkyPicture& coarse, const SunDirection& sun,
                                           const EstimateParameters& options) {
  if (refuse_by_sun(sun, options)) return std::nullopt;
  if (!geometry_ || !geometry_->fits(coarse)) geometry_ = sky_geometry(camera_, coarse);
  const ElementLight sky = sky_light(coarse, *geometry_, sun, options.limits);
  const ExposureStatistics light = statistics_of(coarse, *geometry_, sky);
  if (const auto refused = refuse_by_light(light, sun)) {
    ExposureStatistics nearer = light;
    nearer.dark *= kShareMargin;
    nearer.saturated *= kShareMargin;
    nearer.spread *= kSpreadMargin;
    const auto still = refuse_by_light(nearer, sun);
    return still && still->sky == refused->sky ? std::optional(ClosedSky{*refused}) : std::nullopt;
  }
  // One model alone asks for no colour.
  if (!(options.sky.every_model || options.sky.hosek) || !options.mask_clouds) return std::nullopt;
  const ColourStatistics look = colours_of(coarse, *geometry_, sky, sun);
  const auto refused = refuse_by_look(look, light.brightest);
  if (!refused || refused->sky != SkyCondition::overcast) return std::nullopt;
  ColourStatistics nearer = look;
  nearer.colour_span *= kSpanMargin;
  nearer.bluest -= kBluestMargin;
  if (!refuse_by_look(nearer, light.brightest)) return std::nullopt;
  return ClosedSky{*refused, sun_may_show(coarse, *geometry_, sun)};
}

bool FirstLook::shows_sun(const SkyPicture& whole, const SunDirection& sun) {
  if (!whole_geometry_ || !whole_geometry_->fits(whole)) whole_geometry_ = sky_geometry(camera_, whole);
  ColourStatistics look;
  look_at_sun(look, whole, *whole_geometry_, sun);
  return look.sun_seen;
}

}  // namespace kasumi
