#include "estimator/landmarks/landmark_air.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/exponential.hpp>

#include "base/picture.hpp"
#include "base/statistics.hpp"
#include "estimator/landmarks/daylight.hpp"

namespace kasumi {
namespace {

double number_of(const Extinction& extinction) {
  switch (extinction.kind) {
    case ExtinctionKind::at_most: return extinction.highest_per_m;
    case ExtinctionKind::at_least: return extinction.lowest_per_m;
    default: return extinction.per_m;
  }
}

Image<Rgb8> eight_bits(const Image<glm::vec3>& encoded) {
  Image<Rgb8> picture(encoded.width(), encoded.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    for (int c = 0; c < 3; ++c)
      picture.elements()[i][c] =
          static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(encoded.elements()[i][c], 0.0F, 1.0F)));
  return picture;
}

double middle_path_m(const std::vector<ContrastLandmark>& landmarks, double altitude_m) {
  std::vector<double> paths;
  for (const auto& landmark : landmarks) paths.push_back(haze_path_m(landmark, altitude_m));
  return paths.empty() ? 1000.0 : median(std::move(paths));
}

}  // namespace

std::string_view name_of(Agreement agreement) {
  switch (agreement) {
    case Agreement::agrees: return "agrees";
    case Agreement::disagrees: return "disagrees";
    case Agreement::unknown: break;
  }
  return "unknown";
}

double LandmarkAir::visibility_m() const {
  return kMeteorologicalRange / number_of(extinction());
}
double LandmarkAir::visibility_sigma_m() const {
  return kMeteorologicalRange / (extinction().per_m * extinction().per_m) * extinction().sigma_per_m;
}
double LandmarkAir::optical_range_m() const {
  return kMeteorologicalOpticalRange / number_of(extinction());
}

glm::dvec3 model_extinction_per_m(const AttenuationNodes& nodes, ScatteringModel model, Turbidity turbidity,
                                  double altitude_m, double path_m) {
  const auto left =
      attenuation(haze_coefficients(nodes, model, turbidity), optical_path(altitude_m, altitude_m, path_m));
  return -glm::log(glm::max(left, glm::dvec3{1e-300})) / path_m;
}

LandmarkWatch::LandmarkWatch(const Camera& camera, double altitude_m, std::vector<ContrastLandmark> landmarks,
                             const ContrastSpread& spread, ScatteringModel model)
    : landmarks_(std::move(landmarks)),
      altitude_m_(altitude_m),
      model_(model),
      nodes_(attenuation_nodes(spectral_measure(camera))),
      typical_path_m_(middle_path_m(landmarks_, altitude_m)),
      colours_(camera, landmarks_, altitude_m, spread) {
  const auto clearest = model_extinction_per_m(nodes_, model, Turbidity{1.0}, altitude_m, typical_path_m_);
  for (int c = 0; c < 3; ++c) channels_.emplace_back(landmarks_, altitude_m, clearest[c], c, spread);
}

std::vector<ContrastReading> LandmarkWatch::read(const Camera& camera, const Image<glm::vec3>& encoded,
                                                 const std::optional<Direction>& sun) const {
  if (const auto reason = why_not_daylight(look_for_daylight(encoded), sun); !reason.empty())
    return std::vector<ContrastReading>(landmarks_.size(), {false, reason, {}, {}});
  HorizonLight horizon;
  if (std::any_of(landmarks_.begin(), landmarks_.end(), [](const auto& landmark) { return !landmark.sky; })) {
    const auto picture = eight_bits(encoded);
    horizon = measure_horizon(camera, view_of(picture));
  }
  return read_contrasts(camera, encoded, landmarks_, horizon);
}

LandmarkAir LandmarkWatch::estimate(const std::vector<ContrastReading>& readings) const {
  const auto green = channels_[1].estimate(readings);
  return with_turbidity({channels_[0].estimate(readings), green, channels_[2].estimate(readings)},
                        colours_.estimate(readings, green.left_out));
}

void LandmarkWatch::learn(const std::vector<ContrastReading>& readings) {
  colours_.learn(readings, channels_[1].estimate(readings).left_out);
  for (auto& channel : channels_) channel.learn(readings);
}

void LandmarkWatch::forget(double share) {
  for (auto& channel : channels_) channel.forget(share);
  colours_.forget(share);
}

std::vector<LearntContrasts> LandmarkWatch::learnt() const {
  std::vector<LearntContrasts> all;
  for (const auto& channel : channels_) all.push_back(channel.learnt());
  all.push_back(colours_.learnt());
  return all;
}

bool LandmarkWatch::resume(const std::vector<LearntContrasts>& learnt) {
  const bool older = learnt.size() == channels_.size();  // saved before colours were learnt jointly
  if (!older && learnt.size() != channels_.size() + 1) return false;
  auto resumed = channels_;
  for (std::size_t c = 0; c < resumed.size(); ++c)
    if (!resumed[c].resume(learnt[c])) return false;
  if (!older && !colours_.resume(learnt.back())) return false;
  channels_ = std::move(resumed);
  return true;
}

std::vector<LandmarkAir> LandmarkWatch::estimate_all(const std::vector<std::vector<ContrastReading>>& pictures) const {
  // Each with what the others have taught; of many pictures, a sixteenth at a time.
  constexpr std::size_t kMostParts = 16;
  const auto parts = std::min(kMostParts, pictures.size());
  std::vector<LandmarkAir> airs(pictures.size());
  for (std::size_t part = 0; part < parts; ++part) {
    auto taught = *this;
    for (std::size_t i = 0; i < pictures.size(); ++i)
      if (i % parts != part) taught.learn(pictures[i]);
    for (auto i = part; i < pictures.size(); i += parts) airs[i] = taught.estimate(pictures[i]);
  }
  return airs;
}

LandmarkAir LandmarkWatch::with_turbidity(std::array<Extinction, 3> channels, PathAerosol aerosol) const {
  LandmarkAir air{std::move(channels), {}, std::move(aerosol)};
  const auto& green = air.extinction();
  auto& found = air.turbidity;
  if (green.kind != ExtinctionKind::value) {
    found.reason = green.reason;
    return air;
  }
  const auto model = [&](double t) {
    return model_extinction_per_m(nodes_, model_, Turbidity{t}, altitude_m_, typical_path_m_).g;
  };
  double low = kLowestTurbidity.value, high = kHighestTurbidity.value;
  if (green.per_m < model(low) || green.per_m > model(high)) {
    found.reason = green.per_m < model(low) ? "clearer than T 1.7, where the sky model ends"
                                            : "thicker than T 20, where the scattering model ends";
    return air;
  }
  for (int i = 0; i < 60; ++i) (model(0.5 * (low + high)) < green.per_m ? low : high) = 0.5 * (low + high);
  const double t = 0.5 * (low + high), step = 1e-3;
  found.turbidity = Turbidity{t};
  found.sigma = green.sigma_per_m * 2.0 * step / (model(t + step) - model(t - step));
  return air;
}

SkyComparison LandmarkWatch::compare(const LandmarkAir& air, Turbidity sky, double sky_sigma) const {
  const auto model = [&](double t) {
    return model_extinction_per_m(nodes_, model_, Turbidity{t}, altitude_m_, typical_path_m_).g;
  };
  constexpr double kStep = 1e-3;
  SkyComparison found;
  found.sky_per_m = model(sky.value);
  found.sky_sigma_per_m = sky_sigma * (model(sky.value + kStep) - model(sky.value - kStep)) / (2.0 * kStep);
  const auto& ours = air.extinction();
  const double sigma = std::hypot(ours.sigma_per_m, found.sky_sigma_per_m);
  if (ours.kind == ExtinctionKind::nothing || !(sigma > 0.0)) {
    found.message = ours.reason;
    return found;
  }
  double off = ours.per_m - found.sky_per_m;
  // Everything beyond a bound agrees with it.
  if (ours.kind == ExtinctionKind::at_most) off = std::min(0.0, off);
  if (ours.kind == ExtinctionKind::at_least) off = std::max(0.0, off);
  found.sigmas = off / sigma;
  found.agreement = std::abs(found.sigmas) > kDisagreement_sigmas ? Agreement::disagrees : Agreement::agrees;
  const auto kilometres = [](double per_m) { return kMeteorologicalRange / per_m / 1e3; };
  const auto landmarks = fmt::format("{}{:.1f} km",
                                     ours.kind == ExtinctionKind::at_most    ? "at least "
                                     : ours.kind == ExtinctionKind::at_least ? "at most "
                                                                             : "",
                                     air.visibility_m() / 1e3);
  found.message = fmt::format("visibility from the landmarks {}, from the sky's T {:.2f} {:.1f} km: {}", landmarks,
                              sky.value, kilometres(found.sky_per_m),
                              found.agreement == Agreement::agrees
                                  ? "they agree"
                                  : fmt::format("{:.1f} standard deviations apart", std::abs(found.sigmas)));
  return found;
}

}  // namespace kasumi
