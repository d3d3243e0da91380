#include "estimator/photograph/retarget.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "estimator/light/object_light.hpp"
#include "estimator/photograph/picture_paths.hpp"

namespace kasumi {
namespace {

const glm::dvec3 kGrey{0.3, 0.6, 0.1};

// The way of one pixel's light from the source's air to the target's, all in units of the light from infinity.
struct Way {
  glm::dvec3 left{1.0};   // Gamma_t
  glm::dvec3 ratio{1.0};  // of what the source shows, Gamma_t / Gamma_s as far as it can be restored
  double share = 1.0;     // of the way in logarithms
};

Way way_of(const LogSum& gamma_s, const LogSum& gamma_t, double largest_gain) {
  // Never e^(+800): what is so far beyond the limit is held there anyway.
  Way way{gamma_t.value(),
          glm::exp(glm::min(gamma_t.largest - gamma_s.largest, glm::dvec3{60.0})) * gamma_t.rest / gamma_s.rest, 1.0};
  if (const double gain = std::max({way.ratio.r, way.ratio.g, way.ratio.b}); gain > largest_gain) {
    // The same share of the way in all channels, so that what stays is haze and not a colour. Beyond the limit ever
    // less of the way: what is infinitely far away is sky, and there is no edge between the two.
    way.share = std::log(std::max(1.0, largest_gain * (largest_gain / gain))) / std::log(gain);
    way.ratio = glm::pow(way.ratio, glm::dvec3{way.share});
  }
  return way;
}

// What surfaces send, as it arrives, under the target's light.
class NewLight {
 public:
  explicit NewLight(const RetargetOptions& options)
      : land_(options.relit.land),
        sunlit_contrast_(options.contrast_of_light * (options.relit.land - options.relit.sun)),
        least_(glm::min(options.relit.sun, options.relit.shade)),
        most_(glm::max(options.relit.sun, options.relit.shade)) {}

  glm::dvec3 of(const glm::dvec3& sent) const { return land_ * sent; }
  glm::dvec3 of(const glm::dvec3& sent, const glm::dvec3& around, double share) const {
    const double mean = glm::dot(kGrey, around);
    if (!(mean > 0.0)) return of(sent);
    const auto lit = of(sent) - share * sunlit_contrast_ * around * (glm::dot(kGrey, sent) / mean - 1.0);
    const auto seen = glm::max(sent, glm::dvec3{0.0});
    return glm::clamp(lit, glm::min(least_ * seen, of(sent)), glm::max(most_ * seen, of(sent)));
  }

 private:
  glm::dvec3 land_, sunlit_contrast_, least_, most_;
};

}  // namespace

Retargeted retarget(const Image<glm::vec3>& light, const PictureDepth& depth, const PictureAir& source,
                    const PictureAir& target, const AttenuationNodes& nodes, const RetargetOptions& options,
                    const PictureParts& parts) {
  const PicturePaths before(nodes, options.scattering, source.turbidity),
      after(nodes, options.scattering, target.turbidity);
  const NewLight relit(options);
  Retargeted result{Image<glm::vec3>(light.width(), light.height()),
                    Image<std::uint8_t>(light.width(), light.height(), 255), 0.0};
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const auto from = glm::max(glm::dvec3(source.of(x, y)), glm::dvec3{1e-9}), to = glm::dvec3(target.of(x, y));
      const bool land = depth.distance_m.at(x, y) > 0.0F;
      Way way;
      if (land) {
        const auto path = depth.path(x, y);
        way = way_of(before.transmittance(path), after.transmittance(path), options.largest_gain);
        if (way.share < 1.0) {
          result.restored.at(x, y) = 0;
          result.too_faint_fraction += 1.0;
        }
      }
      const auto under = [&](const glm::dvec3& seen) {
        if (!land) return to * seen / from;
        const auto sent = way.left + way.ratio * (seen / from - 1.0);
        const auto lit = parts.land_around.empty()
                             ? relit.of(sent)
                             : relit.of(sent, way.left * glm::dvec3(parts.land_around.at(x, y)), way.share);
        return to * glm::max(1.0 - way.left + lit, glm::dvec3{0.0});
      };
      const auto seen = glm::dvec3(light.at(x, y));
      auto made = under(seen);
      if (!parts.clean.empty()) {
        constexpr double kDark = 1e-4;  // of full scale; below, noise is not the light's
        const auto clean = glm::dvec3(parts.clean.at(x, y)), signal = under(clean);
        const auto noise = glm::abs(seen - clean) *
                           glm::sqrt(glm::max(signal, glm::dvec3{kDark}) / glm::max(clean, glm::dvec3{kDark}));
        made = signal + glm::clamp(made - signal, -noise, noise);
      }
      result.light.at(x, y) = glm::max(made, glm::dvec3{0.0});
    }
  result.too_faint_fraction /= std::max<double>(1.0, static_cast<double>(light.elements().size()));
  return result;
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

Relighting relighting(const Camera& camera, const std::optional<Turbidity>& source,
                      const std::optional<Turbidity>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m) {
  struct OnGround {
    glm::dvec3 sun, sky;
  };
  const auto on_ground = [&](const std::optional<Turbidity>& turbidity) {
    DaylightOptions options;
    options.altitude_m = altitude_m;
    options.model = SiteSkyModel::preetham;  // the T asked for is the papers', which the dome's table ends long before
    const Daylight daylight(camera, turbidity.value_or(kLowestTurbidity), sun, options);
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
