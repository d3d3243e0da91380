#include "estimator/landmarks/contrast_chroma.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "base/statistics.hpp"
#include "estimator/air/scattering.hpp"

namespace kasumi {
namespace {

// Priors: a camera's chroma is within e^.4 of 1, the middle exponent of a dozen pictures 1.3 +- .35 (physics 11).
constexpr double kLogChromaOfCameras = 0.4, kMiddleExponent = 1.3, kMiddleExponentSigma = 0.35;

// Of the middle picture, were the camera's chroma that.
std::optional<double> middle_exponent(const std::vector<glm::dvec3>& per_m, const glm::dvec3& wavelength_nm,
                                      const glm::dvec3& molecules, double path_m, double chroma, std::size_t& told) {
  constexpr std::size_t kFewest = 12;  // a dozen pictures: fewer may all be of one kind of air
  const glm::dvec3 grey{0.21, 0.72, 0.07};
  std::vector<double> all;
  for (const auto& seen : per_m) {
    const glm::dvec3 contrast = glm::exp(-seen * path_m);
    const double middle = glm::dot(contrast, grey);
    const glm::dvec3 true_contrast = middle + (contrast - middle) / chroma;
    const glm::dvec3 aerosol = -glm::log(glm::max(true_contrast, glm::dvec3(1e-3))) / path_m - molecules;
    // Where there is enough, and not too much.
    if (!(std::min({aerosol.r, aerosol.g, aerosol.b}) > 0.5 * molecules.g) || aerosol.g * path_m > 1.5) continue;
    all.push_back(std::log(aerosol.b / aerosol.r) / std::log(wavelength_nm.r / wavelength_nm.b));
  }
  told = all.size();
  return all.size() < kFewest ? std::optional<double>() : std::optional(median(std::move(all)));
}

}  // namespace

ContrastChroma contrast_chroma(const std::vector<glm::dvec3>& per_m, const glm::dvec3& wavelength_nm, double altitude_m,
                               double path_m) {
  glm::dvec3 molecules{0.0};
  for (int c = 0; c < 3; ++c) molecules[c] = rayleigh_per_m(ScatteringModel::aerosol, wavelength_nm[c], altitude_m);
  ContrastChroma best;
  double least = std::numeric_limits<double>::infinity(), weights = 0.0, sum = 0.0, squares = 0.0;
  std::vector<std::pair<double, double>> costs;  // ln of chroma, and its cost
  for (int k = -20; k <= 28; ++k) {
    const double log_chroma = 0.05 * k;
    std::size_t told = 0;
    const auto found = middle_exponent(per_m, wavelength_nm, molecules, path_m, std::exp(log_chroma), told);
    if (!found) continue;
    const double cost =
        square(log_chroma / kLogChromaOfCameras) + square((*found - kMiddleExponent) / kMiddleExponentSigma);
    costs.emplace_back(log_chroma, cost);
    if (cost < least) least = cost, best.chroma = std::exp(log_chroma), best.pictures = told;
  }
  for (const auto& [log_chroma, cost] : costs) {
    const double weight = std::exp(-0.5 * (cost - least));
    weights += weight, sum += weight * log_chroma, squares += weight * square(log_chroma);
  }
  if (costs.size() < 2) return {};
  constexpr double kStep = 0.05;  // of the search
  best.log_sigma = std::max(std::sqrt(std::max(0.0, squares / weights - square(sum / weights))), kStep);
  return best;
}

double saturation_believed(const ContrastChroma& learnt) {
  if (!learnt.known()) return 1.0;
  const double found = std::log(learnt.chroma), variance = square(learnt.log_sigma);
  // The likelihood of what was seen, which `learnt` has narrowed by the same belief about cameras that exaggerate.
  const double seen_variance = 1.0 / std::max(1.0 / variance - 1.0 / square(kLogChromaOfCameras), 0.1 / variance);
  const double seen = found * seen_variance / variance;
  const auto density = [&](double all) { return std::exp(-0.5 * square(seen) / all) / std::sqrt(all); };
  const double exaggerates = density(seen_variance + square(kLogChromaOfCameras)), exact = density(seen_variance);
  const double believed = exaggerates / (exaggerates + exact) * found;
  constexpr double kUnseen = 0.01;  // chosen: one per cent of colour is not visible, so it is left at exactly 1
  return std::abs(believed) < kUnseen ? 1.0 : std::exp(believed);
}

}  // namespace kasumi
