#include "estimator/photograph/path_transmittance.hpp"

#include <array>

#include <glm/common.hpp>

namespace kasumi {

PathTransmittance::PathTransmittance(const AttenuationNodes& nodes, ScatteringModel model,
                                     const std::optional<AirState>& air)
    : nodes_(nodes), clear_(!air) {
  if (air) haze_ = haze_coefficients(nodes, model, *air);
}

LogSum PathTransmittance::transmittance(const OpticalPath& path) const {
  std::array<glm::dvec3, kAttenuationNodes> logs{};
  LogSum sum{glm::dvec3{-1e300}, glm::dvec3{0.0}};
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (!clear_) logs[i] = -(haze_.rayleigh_per_m[i] * path.rayleigh_m + haze_.mie_per_m[i] * path.mie_m);
    sum.largest = glm::max(sum.largest, logs[i]);
  }
  for (std::size_t i = 0; i < logs.size(); ++i) sum.rest += nodes_.weight[i] * glm::exp(logs[i] - sum.largest);
  sum.rest = glm::max(sum.rest, glm::dvec3{1e-12});  // weights of mixed channels may be negative
  return sum;
}

}  // namespace kasumi
