#include "calib/light/merged_exposures.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/common.hpp>

#include "base/saturation.hpp"
#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr double kLeastRatio = 1.25;
constexpr double kMostRatioScatter = 0.2;  // of ln of the ratio over the pixels: more than noise and JPEG make
constexpr double kTooDarkToMerge = 0.04;   // encoded: below, the last bits and the black level count
constexpr double kNearlyFull = 0.9;   // encoded: from there to kSaturated the weight fades, so that no edge is left
constexpr double kSkyFull = 0.9;      // encoded: where the brightest_of of the sky comes to lie
constexpr double kBrightest = 0.995;  // share of the pixels that are darker: the sun and its glow are left out
constexpr std::size_t kMergeSamples = 20'000, kLeastMergeOverlap = 200;

double brightest_of(const glm::dvec3& value) {
  return std::max({value.r, value.g, value.b});
}
double darkest_of(const glm::dvec3& value) {
  return std::min({value.r, value.g, value.b});
}

// ln of the light of `longer` to that of `shorter`; empty: too few pixels show both, or they disagree.
std::optional<double> log_ratio(const Image<glm::vec3>& shorter, const Image<glm::vec3>& longer,
                                const Response& response) {
  const std::size_t step = std::max<std::size_t>(1, shorter.elements().size() / kMergeSamples);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < shorter.elements().size(); i += step) {
    const glm::dvec3 low(shorter.elements()[i]), high(longer.elements()[i]);
    if (darkest_of(low) < kTooDarkToMerge || darkest_of(high) < kTooDarkToMerge || brightest_of(low) > kSaturated ||
        brightest_of(high) > kSaturated)
      continue;
    ratios.push_back(std::log(response.to_light(high).g / response.to_light(low).g));
  }
  if (ratios.size() < kLeastMergeOverlap) return std::nullopt;
  const double middle = median(ratios);
  for (auto& ratio : ratios) ratio = std::abs(ratio - middle);
  return kSigmaOverMedianSize * median(std::move(ratios)) <= kMostRatioScatter ? std::optional(middle) : std::nullopt;
}

double exposure_weight(const glm::dvec3& encoded, double exposure) {
  const double full = std::clamp((kSaturated - brightest_of(encoded)) / (kSaturated - kNearlyFull), 0.0, 1.0);
  return exposure * full * (darkest_of(encoded) < kTooDarkToMerge ? 0.01 : 1.0);
}

double mean_green(const Image<glm::vec3>& picture) {
  const std::size_t step = std::max<std::size_t>(1, picture.elements().size() / kMergeSamples);
  double sum = 0.0;
  for (std::size_t i = 0; i < picture.elements().size(); i += step) sum += static_cast<double>(picture.elements()[i].g);
  return sum;
}

}  // namespace

std::optional<MergedExposures> merge_exposures(const std::vector<Photograph>& exposures, const Response& response) {
  if (exposures.size() < 2) return std::nullopt;
  for (const auto& each : exposures)
    if (each.encoded.width() != exposures.front().encoded.width() ||
        each.encoded.height() != exposures.front().encoded.height())
      return std::nullopt;
  std::vector<std::size_t> order(exposures.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> means;
  for (const auto& each : exposures) means.push_back(mean_green(each.encoded));
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return means[i]; });

  MergedExposures merged;
  merged.ratios.resize(exposures.size(), 1.0);
  for (std::size_t k = 1; k < order.size(); ++k) {
    const auto ratio = log_ratio(exposures[order[k - 1]].encoded, exposures[order[k]].encoded, response);
    if (!ratio) return std::nullopt;
    merged.ratios[order[k]] = merged.ratios[order[k - 1]] * std::exp(*ratio);
  }
  if (merged.ratios[order.back()] < kLeastRatio) return std::nullopt;

  const auto& shortest = exposures[order.front()];
  merged.picture.quantum = shortest.quantum;
  merged.picture.origin = shortest.origin;
  merged.picture.opacity = shortest.opacity;
  auto& light = merged.picture.encoded = Image<glm::vec3>(shortest.encoded.width(), shortest.encoded.height());
  for (std::size_t i = 0; i < light.elements().size(); ++i) {
    const glm::dvec3 least(shortest.encoded.elements()[i]);
    glm::dvec3 sum = 1e-6 * response.to_light(least);  // where none is of use: the shortest
    double weights = 1e-6;
    for (std::size_t k = 0; k < exposures.size(); ++k) {
      const glm::dvec3 encoded(exposures[k].encoded.elements()[i]);
      const double weight = exposure_weight(encoded, merged.ratios[k]);
      sum += weight / merged.ratios[k] * response.to_light(encoded);
      weights += weight;
    }
    light.elements()[i] = glm::vec3(sum / weights);
  }

  std::vector<double> sampled;
  const std::size_t step = std::max<std::size_t>(1, light.elements().size() / kMergeSamples);
  for (std::size_t i = 0; i < light.elements().size(); i += step)
    sampled.push_back(brightest_of(glm::dvec3(light.elements()[i])));
  const auto at = sampled.begin() + static_cast<std::ptrdiff_t>(kBrightest * static_cast<double>(sampled.size() - 1));
  std::ranges::nth_element(sampled, at);
  const double gain =
      std::clamp(response.to_light(glm::dvec3(kSkyFull)).g / std::max(*at, 1e-9), 1.0, merged.ratios[order.back()]);
  for (auto& value : light.elements())
    value = glm::vec3(glm::min(response.to_encoded(gain * glm::dvec3(value)), glm::dvec3(1.0)));
  return merged;
}

}  // namespace kasumi
