#include <algorithm>

#include <glm/geometric.hpp>

#include "calib/radiometry.hpp"

namespace kasumi {

double Vignetting::at(const glm::dvec2& pixel) const {
  const glm::dvec2 offset = (pixel - centre) / radius_px;
  const double r2 = glm::dot(offset, offset);
  const double illumination = 1.0 + r2 * (coefficients[0] + r2 * (coefficients[1] + r2 * coefficients[2]));
  return std::max(illumination, 1e-3);  // outside the lens's reach, where the fit says nothing
}

}  // namespace kasumi
