#include "estimator/sky_camera/sky_sensitivity.hpp"

#include <algorithm>

#include <fmt/ranges.h>

#include "estimator/sky_camera/sky_colours.hpp"

namespace kasumi {
namespace {

struct Skies {
  std::vector<DaylightColour> colours;
  std::vector<double> turbidities;
  std::vector<std::string> refused;
};

// The colours of all skies that are clear enough, measured with the current estimate of the camera.
Skies look_at(std::span<const SunMoment> moments, const Camera& camera, const std::optional<double>& turbidity) {
  Skies skies;
  SkyObserver observer(camera);
  for (const auto& moment : moments) {
    const auto observation = observer.observe(moment.picture, moment.sun);
    if (!observation.estimate.usable) {
      skies.refused.push_back(fmt::format("{}: {}", moment.name, observation.estimate.reason));
      continue;
    }
    const double t = turbidity.value_or(observation.estimate.turbidity.value);
    const auto more =
        sky_colours(moment.picture, observation, camera, Turbidity{t}, static_cast<int>(skies.turbidities.size()));
    skies.colours.insert(skies.colours.end(), more.begin(), more.end());
    skies.turbidities.push_back(t);
  }
  return skies;
}

std::vector<RankedSensitivity> rank(std::span<const DaylightColour> colours,
                                    std::span<const SpectralSensitivity> cameras) {
  std::vector<RankedSensitivity> ranked;
  for (std::size_t i = 0; i < cameras.size(); ++i) ranked.push_back({i, explain(colours, cameras[i])});
  std::stable_sort(ranked.begin(), ranked.end(), [](const RankedSensitivity& a, const RankedSensitivity& b) {
    return a.residuals.rms < b.residuals.rms;
  });
  return ranked;
}

double error_of_more_colourful_sky(const SensitivityFit& fit, std::vector<DaylightColour> colours,
                                   std::span<const SpectralSensitivity> cameras) {
  for (auto& colour : colours) {
    colour.spectrum.m1 *= 1.0 + kMoreColourful;
    colour.spectrum.m2 *= 1.0 + kMoreColourful;
  }
  const auto other = fit_sensitivity(colours, cameras);
  return other ? gamma_error(fit.sensitivity, other->sensitivity).largest : 0.0;
}

}  // namespace

Result<FoundSensitivity> sensitivity_from_sky(Camera camera, std::span<const SunMoment> moments,
                                              std::span<const SpectralSensitivity> cameras,
                                              const SensitivityRequest& options) {
  FoundSensitivity found;
  Skies skies;
  constexpr int kRounds = 3;                        // T and sensitivity by turns
  camera.colour_space = Camera::ColourSpace::srgb;  // mostly green, a good enough luminance to begin with
  for (int round = 0; round < kRounds; ++round) {
    skies = look_at(moments, camera, options.turbidity);
    if (skies.turbidities.empty())
      return fail(FaultKind::bad_input, "{}{}{}",
                  round == 0 ? "no picture shows a clear enough sky: expected some pictures of a cloudless day"
                             : "with the best-fitting sensitivity no picture shows a clear sky: expected the "
                               "sensor's own colours (not converted by the camera), and the recording's right T",
                  skies.refused.empty() ? "" : "\n", fmt::join(skies.refused, "\n"));
    found.ranked = rank(skies.colours, cameras);
    found.sensitivity = cameras[found.ranked.front().camera];
    found.residuals = found.ranked.front().residuals;
    if (cameras.size() >= 2) {
      auto fit = fit_sensitivity(skies.colours, cameras);
      if (!fit) return fail(fit.error());
      found.fit = std::move(*fit);
      if (!options.choose) {
        found.sensitivity = found.fit->sensitivity;
        found.residuals = found.fit->residuals;
      }
    }
    camera.colour_space = Camera::ColourSpace::sensor;
    camera.sensitivity = found.sensitivity;
    camera.white_balance = found.residuals.white_balance;
  }
  found.expected = leave_one_out(skies.colours, found.residuals.left, cameras);
  if (found.fit && !options.choose)
    found.of_more_colourful_sky = error_of_more_colourful_sky(*found.fit, skies.colours, cameras);
  found.colours = skies.colours.size();
  found.turbidities = std::move(skies.turbidities);
  found.refused = std::move(skies.refused);
  return found;
}

}  // namespace kasumi
