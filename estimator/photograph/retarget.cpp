#include "estimator/photograph/retarget.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "estimator/light/object_light.hpp"
#include "estimator/photograph/path_transmittance.hpp"

namespace kasumi {
namespace {

const glm::dvec3 kGreyWeights{0.3, 0.6, 0.1};

// How one pixel changes from the source's air to the target's, all in units of the light from infinity.
struct RetargetChange {
  glm::dvec3 transmittance{1.0};  // Gamma_t
  glm::dvec3 ratio{1.0};          // of the source's light, Gamma_t / Gamma_s as far as it can be restored
  double share = 1.0;             // of the change, in logarithms
};

RetargetChange air_change(const LogSum& gamma_s, const LogSum& gamma_t, double largest_gain) {
  // Avoids e^(+800): anything so far beyond the limit is held there anyway.
  RetargetChange change{
      gamma_t.value(),
      glm::exp(glm::min(gamma_t.largest - gamma_s.largest, glm::dvec3{60.0})) * gamma_t.rest / gamma_s.rest, 1.0};
  if (const double gain = std::max({change.ratio.r, change.ratio.g, change.ratio.b}); gain > largest_gain) {
    // The same share of the change in all channels, so that what remains is haze and not a colour cast. Beyond the
    // limit the share falls towards zero: what is infinitely far away is sky, and there must be no edge between the
    // two.
    change.share = std::log(std::max(1.0, largest_gain * (largest_gain / gain))) / std::log(gain);
    change.ratio = glm::pow(change.ratio, glm::dvec3{change.share});
  }
  return change;
}

// The light of surfaces under the target's light, as it arrives at the camera.
class LightUnderTarget {
 public:
  explicit LightUnderTarget(const RetargetLimits& options)
      : land_(options.relit.land),
        sunlit_contrast_(options.contrast_of_light * (options.relit.land - options.relit.sun)),
        least_(glm::min(options.relit.sun, options.relit.shade)),
        most_(glm::max(options.relit.sun, options.relit.shade)) {}

  glm::dvec3 of(const glm::dvec3& sent) const { return land_ * sent; }
  glm::dvec3 of(const glm::dvec3& sent, const glm::dvec3& around, double share) const {
    const double mean = glm::dot(kGreyWeights, around);
    if (!(mean > 0.0)) return of(sent);
    const auto lit = of(sent) - share * sunlit_contrast_ * around * (glm::dot(kGreyWeights, sent) / mean - 1.0);
    const auto seen = glm::max(sent, glm::dvec3{0.0});
    return glm::clamp(lit, glm::min(least_ * seen, of(sent)), glm::max(most_ * seen, of(sent)));
  }

 private:
  glm::dvec3 land_, sunlit_contrast_, least_, most_;
};

}  // namespace

Retargeted retarget(const Image<glm::vec3>& light, const RetargetGeometry& depth, const RetargetAir& source,
                    const RetargetAir& target, const AttenuationNodes& nodes, const RetargetLimits& options,
                    const RetargetHints& parts) {
  const PathTransmittance before(nodes, options.scattering, source.state),
      after(nodes, options.scattering, target.state);
  const LightUnderTarget relit(options);
  Retargeted result{Image<glm::vec3>(light.width(), light.height()),
                    Image<std::uint8_t>(light.width(), light.height(), 255),
                    0.0,
                    {}};
  if (options.terms) result.airlight = Image<glm::vec3>(light.width(), light.height());
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const auto from = glm::max(glm::dvec3(source.of(x, y)), glm::dvec3{1e-9}), to = glm::dvec3(target.of(x, y));
      const bool land = depth.distance_m.at(x, y) > 0.0F;
      RetargetChange change;
      if (land) {
        const auto path = depth.path(x, y);
        change = air_change(before.transmittance(path), after.transmittance(path), options.largest_gain);
        if (change.share < 1.0) {
          result.restored.at(x, y) = 0;
          result.too_faint_fraction += 1.0;
        }
      }
      const auto under = [&](const glm::dvec3& seen) {
        if (!land) return to * seen / from;
        const auto sent = change.transmittance + change.ratio * (seen / from - 1.0);
        const auto lit =
            parts.land_around.empty()
                ? relit.of(sent)
                : relit.of(sent, change.transmittance * glm::dvec3(parts.land_around.at(x, y)), change.share);
        return to * glm::max(1.0 - change.transmittance + lit, glm::dvec3{0.0});
      };
      const auto seen = glm::dvec3(light.at(x, y));
      auto made = under(seen);
      if (!parts.clean.empty()) {
        constexpr double kDark = 1e-4;  // of full scale; below, the noise does not come from the light
        const auto clean = glm::dvec3(parts.clean.at(x, y)), signal = under(clean);
        const auto noise = glm::abs(seen - clean) *
                           glm::sqrt(glm::max(signal, glm::dvec3{kDark}) / glm::max(clean, glm::dvec3{kDark}));
        made = signal + glm::clamp(made - signal, -noise, noise);
      }
      made = glm::max(made, glm::dvec3{0.0});
      result.light.at(x, y) = made;
      if (options.terms) result.airlight.at(x, y) = land ? glm::min(to * (1.0 - change.transmittance), made) : made;
    }
  result.too_faint_fraction /= std::max<double>(1.0, static_cast<double>(light.elements().size()));
  return result;
}

DaylightModel sky_model_of(const AirState& air) {
  return air.aerosol_known() ? DaylightModel::dome : DaylightModel::preetham;
}

AirState clearest_like(const std::optional<AirState>& air) {
  if (!air || !air->aerosol_known()) return kLowestTurbidity;
  Aerosol none = air->aerosol();
  none.aod_550 = 0.0;
  return none;
}

Image<glm::vec3> light_from_infinity(const Camera& camera, const Airlight& airlight) {
  Image<glm::vec3> light(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y})) light.at(x, y) = airlight.from(*direction);
  return light;
}

Image<float> rise_of(const Camera& camera) {
  Image<float> rise(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y})) rise.at(x, y) = static_cast<float>(direction->z);
  return rise;
}

Relighting relighting(const Camera& camera, const std::optional<AirState>& source,
                      const std::optional<AirState>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m) {
  struct OnGround {
    glm::dvec3 sun, sky;
  };
  const auto on_ground = [&](const std::optional<AirState>& air) {
    const AirState state = air.value_or(clearest_like(source ? source : target));
    DaylightConditions options;
    options.altitude_m = altitude_m;
    options.model = sky_model_of(state);
    const Daylight daylight(camera, state, sun, options);
    const auto& light = daylight.on_object();
    const auto unit = daylight.airlight(raised_to_horizon(view));
    return OnGround{light.sun_irradiance * std::max(0.0, sun.z) / unit, irradiance(light.around, {0, 0, 1}) / unit};
  };
  const auto before = on_ground(source), after = on_ground(target);
  const auto land = (after.sun + after.sky) / (before.sun + before.sky);
  Relighting found{land, land, land};
  for (int c = 0; c < 3; ++c)
    if (before.sun[c] > 0.0 && before.sky[c] > 0.0) {
      found.sun[c] = after.sun[c] / before.sun[c];
      found.shade[c] = after.sky[c] / before.sky[c];
    }
  return found;
}

}  // namespace kasumi
