#include "estimator/retarget.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "estimator/object_light.hpp"

namespace kasumi {
namespace {

// What a path leaves of light under the two airs.
class Paths {
 public:
  Paths(const AttenuationNodes& nodes, ScatteringModel model, const std::optional<Turbidity>& turbidity)
      : clear_(!turbidity) {
    if (turbidity) haze_ = haze_coefficients(nodes, model, *turbidity);
  }
  // ln of each node's transmittance; its weight stands beside it.
  glm::dvec3 log_of(int node, const OpticalPath& path) const {
    if (clear_) return glm::dvec3{0.0};
    const auto i = static_cast<std::size_t>(node);
    return -(haze_.rayleigh_per_m[i] * path.rayleigh_m + haze_.mie_per_m[i] * path.mie_m);
  }

 private:
  bool clear_;
  HazeCoefficients haze_;
};

// sum of w e^a as e^largest * sum of w e^(a - largest), so that the quotient of two of them holds where both vanish.
struct LogSum {
  glm::dvec3 largest, rest;
};
LogSum log_sum(const AttenuationNodes& nodes, const Paths& paths, const OpticalPath& path) {
  std::array<glm::dvec3, kAttenuationNodes> logs;
  LogSum sum{glm::dvec3{-1e300}, glm::dvec3{0.0}};
  for (int i = 0; i < kAttenuationNodes; ++i) {
    logs[static_cast<std::size_t>(i)] = paths.log_of(i, path);
    sum.largest = glm::max(sum.largest, logs[static_cast<std::size_t>(i)]);
  }
  for (std::size_t i = 0; i < logs.size(); ++i) sum.rest += nodes.weight[i] * glm::exp(logs[i] - sum.largest);
  sum.rest = glm::max(sum.rest, glm::dvec3{1e-12});  // weights of mixed channels may be negative
  return sum;
}

const glm::vec3& of_pixel(const Image<glm::vec3>& image, int x, int y) {
  return image.width() == 1 && image.height() == 1 ? image.at(0, 0) : image.at(x, y);
}

}  // namespace

Retargeted retarget(const Image<glm::vec3>& light, const PictureDepth& depth, const PictureAir& source,
                    const PictureAir& target, const AttenuationNodes& nodes, const RetargetOptions& options) {
  const Paths before(nodes, options.scattering, source.turbidity), after(nodes, options.scattering, target.turbidity);
  Retargeted result{Image<glm::vec3>(light.width(), light.height()),
                    Image<std::uint8_t>(light.width(), light.height(), 255), 0.0};
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const glm::dvec3 from = of_pixel(source.from_infinity, x, y), to = of_pixel(target.from_infinity, x, y);
      const auto relative = glm::dvec3(light.at(x, y)) / glm::max(from, glm::dvec3{1e-9});
      const double distance_m = static_cast<double>(depth.distance_m.at(x, y));
      if (!(distance_m > 0.0)) {
        result.light.at(x, y) = to * relative;
        continue;
      }
      const double rise = depth.rise.empty() ? 0.0 : static_cast<double>(depth.rise.at(x, y));
      const auto path =
          optical_path(depth.observer_altitude_m, depth.observer_altitude_m + rise * distance_m, distance_m);
      const LogSum gamma_s = log_sum(nodes, before, path), gamma_t = log_sum(nodes, after, path);
      // Never e^(+800): what is so far beyond the limit is held there anyway.
      auto ratio =
          glm::exp(glm::min(gamma_t.largest - gamma_s.largest, glm::dvec3{60.0})) * gamma_t.rest / gamma_s.rest;
      if (const double gain = std::max({ratio.r, ratio.g, ratio.b}); gain > options.largest_gain) {
        result.restored.at(x, y) = 0;
        result.too_faint_fraction += 1.0;
        // The same share of the way in all channels, so that what stays is haze and not a colour. Beyond the limit ever
        // less of the way: what is infinitely far away is sky, and there is no edge between the two.
        const double allowed = std::max(1.0, options.largest_gain * (options.largest_gain / gain));
        ratio = glm::pow(ratio, glm::dvec3{std::log(allowed) / std::log(gain)});
      }
      const auto left = glm::exp(gamma_t.largest) * gamma_t.rest;
      const auto seen = 1.0 + options.relit * ratio * (relative - 1.0) + left * (options.relit - 1.0);
      result.light.at(x, y) = to * glm::max(seen, glm::dvec3{0.0});
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

glm::dvec3 relighting(const Camera& camera, const std::optional<Turbidity>& source,
                      const std::optional<Turbidity>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m) {
  const auto on_ground = [&](const std::optional<Turbidity>& turbidity) {
    DaylightOptions options;
    options.altitude_m = altitude_m;
    options.model = SiteSkyModel::preetham;  // the T asked for is the papers', which the dome's table ends long before
    const Daylight daylight(camera, turbidity.value_or(kLowestTurbidity), sun, options);
    const auto& light = daylight.on_object();
    const auto level = light.sun_irradiance * std::max(0.0, sun.z) + irradiance(light.around, {0, 0, 1});
    return level / daylight.airlight(raised_to_horizon(view));
  };
  return on_ground(target) / on_ground(source);
}

}  // namespace kasumi
