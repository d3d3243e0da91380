// Transmittance of the light paths through a photograph, in a form that stays exact where nothing is left.
#pragma once

#include <optional>

#include <glm/exponential.hpp>
#include <glm/vec3.hpp>

#include "estimator/air/attenuation.hpp"

namespace kasumi {

// e^largest * rest in each channel, so that the quotient of two of them stays finite where both vanish.
struct LogSum {
  glm::dvec3 largest, rest;
  glm::dvec3 value() const { return glm::exp(largest) * rest; }
};

class PathTransmittance {
 public:
  // Nothing: no air.
  PathTransmittance(const AttenuationNodes& nodes, ScatteringModel model, const std::optional<AirState>& air);
  LogSum transmittance(const OpticalPath& path) const;

 private:
  AttenuationNodes nodes_;
  bool clear_;
  HazeCoefficients haze_;
};

}  // namespace kasumi
