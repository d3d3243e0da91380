#include "estimator/landmarks/channel_extinctions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/aerosol.hpp"
#include "base/picture.hpp"
#include "base/square.hpp"
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

constexpr double kUsualAod = 0.06;  // of the air near the ground at the median hour, over Europe: some .05 per km
// Of alternation: cold, and with one more picture beside those that are solved.
constexpr int kStepsFromNothing = 25, kStepsOnward = 4;

// Extinction that grows with wavelength is no air: warm sunlight on the surface.
bool lit_by_colour(const std::vector<LandmarkExtinction>& channels, std::size_t landmark,
                   const ContrastReading& reading) {
  // What is left is read as at least a tenth, else noise decides the logarithm; lit where red loses .1 more than blue.
  constexpr double kFaint = 0.1, kRedder = 0.1;
  double red = 0.0, blue = 0.0, variance = 0.0;
  for (const int c : {0, 2}) {
    const auto& belief = channels[static_cast<std::size_t>(c)].belief();
    const double floor = belief.floor[landmark], whole = belief.mean[landmark] - floor;
    const double left = std::max(reading.contrast[c] - floor, kFaint);
    (c == 0 ? red : blue) = -std::log(left / whole);
    variance +=
        square(reading.sigma[c] / left) + belief.covariance[landmark * (belief.mean.size() + 1)] / square(whole);
  }
  return red > kRedder && red > blue + kRedder + 2.0 * std::sqrt(variance);
}

// Whether two pictures say the same: within what reading them is unsure of.
bool look_alike(const std::vector<ContrastReading>& one, const std::vector<ContrastReading>& other) {
  if (one.size() != other.size()) return false;
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (one[i].usable != other[i].usable) return false;
    if (!one[i].usable) continue;
    for (int c = 0; c < 3; ++c, ++count)
      squares +=
          square(one[i].contrast[c] - other[i].contrast[c]) / (square(one[i].sigma[c]) + square(other[i].sigma[c]));
  }
  constexpr double kAlike = 0.25;  // of what chance alone would make
  return count > 0 && squares < kAlike * count;
}

std::array<glm::dvec3, 3> shape_of(const Response& response) {
  const auto full = response.to_light(glm::dvec3{1.0});
  std::array<glm::dvec3, 3> shape;
  for (int i = 0; i < 3; ++i) shape[static_cast<std::size_t>(i)] = response.to_light(glm::dvec3{0.25 * (i + 1)}) / full;
  return shape;
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

double ChannelExtinctions::visibility_m() const {
  return kMeteorologicalRange / number_of(extinction());
}
double ChannelExtinctions::visibility_sigma_m() const {
  return kMeteorologicalRange / (extinction().per_m * extinction().per_m) * extinction().sigma_per_m;
}
double ChannelExtinctions::optical_range_m() const {
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
      response_(shape_of(camera.response)),
      altitude_m_(altitude_m),
      spread_(spread),
      model_(model),
      nodes_(attenuation_nodes(spectral_measure(camera))),
      typical_path_m_(middle_path_m(landmarks_, altitude_m)),
      colours_(camera, landmarks_, altitude_m, spread) {
  const auto clearest = model_extinction_per_m(nodes_, model, Turbidity{1.0}, altitude_m, typical_path_m_);
  const double column_m = kAerosolHeight_m * std::exp(altitude_m / kAerosolHeight_m);
  for (int c = 0; c < 3; ++c) {
    channels_.emplace_back(landmarks_, altitude_m, clearest[c], c, spread);
    const double usual_per_m = kUsualAod / column_m * std::pow(colours_.wavelength_nm()[c] / 550.0, -1.3);
    const double molecules = rayleigh_per_m(ScatteringModel::aerosol, colours_.wavelength_nm()[c], altitude_m);
    joint_.emplace_back(laws_of(landmarks_, altitude_m), belief_before(landmarks_, spread), molecules, usual_per_m,
                        spread);
    usual_per_m_[c] = molecules + usual_per_m;
  }
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
  auto readings = read_contrasts(camera, encoded, landmarks_, horizon);
  if (sun) mark_lit(landmarks_, *sun, readings);
  return readings;
}

std::vector<ContrastReading> LandmarkWatch::judged(std::vector<ContrastReading> readings) const {
  readings.resize(landmarks_.size(), {false, "not read", {}, {}});
  refuse_dark_skies(landmarks_, readings);
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (readings[i].usable && !landmarks_[i].against && lit_by_colour(channels_, i, readings[i]))
      readings[i].lit = true;
  return readings;
}

void LandmarkWatch::solve(const std::vector<KeptReadings>& pictures, int most_steps) {
  std::vector<std::vector<ContrastReading>> all;
  for (const auto& one : pictures) all.push_back(judged(one.readings));
  for (int c = 0; c < 3; ++c) {
    std::vector<ChannelSample> channel;
    for (std::size_t t = 0; t < all.size(); ++t) {
      ChannelSample picture{{}, pictures[t].day};
      for (const auto& one : all[t])
        picture.readings.push_back({one.contrast[c], one.sigma[c], one.usable && !one.lit});
      channel.push_back(std::move(picture));
    }
    joint_[static_cast<std::size_t>(c)].solve(channel, most_steps);
  }
  std::vector<ToneSample> green;
  std::vector<glm::dvec3> per_m;
  for (std::size_t t = 0; t < pictures.size(); ++t)
    per_m.emplace_back(joint_[0].per_m()[t], joint_[1].per_m()[t], joint_[2].per_m()[t]);
  chroma_ = contrast_chroma(per_m, colours_.wavelength_nm(), altitude_m_, typical_path_m_);
  colours_.set_chroma(chroma_.chroma);
  for (std::size_t t = 0; t < all.size(); ++t) {
    green.push_back({{}, per_m[t].g});
    for (const auto& one : all[t])
      green.back().readings.push_back({one.contrast.g, one.sigma.g, one.usable && !one.lit});
  }
  tone_ = contrast_tone(green, laws_of(landmarks_, altitude_m_), belief_before(landmarks_, spread_), usual_per_m_.g,
                        spread_);
  believe(std::nullopt);
}

void LandmarkWatch::believe(std::optional<std::size_t> without) {
  std::array<LearntConstants, 3> learnt;
  std::array<std::vector<double>, 3> scatter;
  for (std::size_t c = 0; c < 3; ++c) {
    auto belief = joint_[c].belief_without(without);
    learnt[c] = joint_[c].learnt_without(without);
    scatter[c] = belief.scatter;
    channels_[c].believe(std::move(belief));
  }
  colours_.believe(learnt, scatter);
}

ChannelExtinctions LandmarkWatch::estimate(const std::vector<ContrastReading>& all) const {
  const auto readings = judged(all);
  const auto green = channels_[1].estimate(readings);
  // Chosen: colours may differ from green's interval by that factor, and are not asked near pure air.
  constexpr double kMargin = 2.0;
  const double molecules = rayleigh_per_m(ScatteringModel::aerosol, 550.0, altitude_m_);
  std::optional<LandmarkColours::Within> within;
  if (green.kind == ExtinctionKind::value && green.lowest_per_m > kMargin * molecules)
    within = {(green.lowest_per_m - molecules) / kMargin, green.highest_per_m * kMargin};
  return agreed(with_turbidity({channels_[0].estimate(readings), green, channels_[2].estimate(readings)},
                               colours_.estimate(readings, green.left_out, within)),
                readings);
}

// Compares the extinction by near landmarks with that by far ones.
ChannelExtinctions LandmarkWatch::agreed(ChannelExtinctions air, const std::vector<ContrastReading>& readings) const {
  // Landmarks whose distances differ by 1.4 and more are solved separately as well; results that differ by over 20 %
  // are reported (physics 11).
  constexpr double kApart = 1.4, kAgree = 1.2;
  if (air.extinction().kind != ExtinctionKind::value) return air;
  std::vector<double> paths;
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (readings[i].usable) paths.push_back(haze_path_m(landmarks_[i], altitude_m_));
  const auto [nearest, farthest] = std::ranges::minmax(paths);
  if (farthest < kApart * nearest) return air;
  const double middle = std::sqrt(nearest * farthest);
  auto near = readings, far = readings;
  for (std::size_t i = 0; i < readings.size(); ++i)
    (haze_path_m(landmarks_[i], altitude_m_) < middle ? far : near)[i].usable = false;
  const auto by_near = channels_[1].estimate(near), by_far = channels_[1].estimate(far);
  if (by_near.kind != ExtinctionKind::value || by_far.kind != ExtinctionKind::value) return air;
  const double ratio = std::max(by_near.per_m / by_far.per_m, by_far.per_m / by_near.per_m);
  if (ratio <= kAgree) return air;
  const double apart = 0.5 * std::abs(by_near.per_m - by_far.per_m) / air.extinction().per_m;  // as a share
  air.doubt = fmt::format("near landmarks say {:.3f} per km, far ones {:.3f}", 1e3 * by_near.per_m, 1e3 * by_far.per_m);
  const double before = air.extinction().sigma_per_m;
  for (auto& channel : air.channels) {
    if (channel.kind != ExtinctionKind::value) continue;
    channel.sigma_per_m = std::hypot(channel.sigma_per_m, apart * channel.per_m);
    channel.lowest_per_m = std::min(channel.lowest_per_m, std::max(0.0, channel.per_m - 2.0 * channel.sigma_per_m));
    channel.highest_per_m = std::max(channel.highest_per_m, channel.per_m + 2.0 * channel.sigma_per_m);
  }
  air.aerosol.covariance.per_m += square(apart * air.aerosol.per_m);
  // What makes them differ has a colour, that of changing light; the exponent is unknown at most.
  constexpr double kUnknownExponent = 0.87;  // sigma of the even belief in -.5 to 2.5
  const double by_colour = apart * std::sqrt(2.0 * (1.0 - ColourSpread{}.lit));
  const auto nm = colours_.wavelength_nm();
  double& exponent = air.aerosol.covariance.exponent;
  exponent =
      std::max(exponent, std::min(exponent + square(by_colour / std::log(nm.r / nm.b)), square(kUnknownExponent)));
  air.turbidity.sigma *= air.extinction().sigma_per_m / before;
  return air;
}

void LandmarkWatch::learn(const std::vector<ContrastReading>& readings, std::optional<double> day) {
  if (landmarks_.empty() || std::ranges::none_of(readings, &ContrastReading::usable)) return;
  if (!kept_.empty() && look_alike(kept_.back().readings, readings))
    kept_.back() = {readings, day};
  else
    kept_.push_back({readings, day});
  if (kept_.size() > kMostKept) kept_.erase(kept_.begin(), kept_.end() - kMostKept);
  solve(kept_, kept_.size() < 20 ? kStepsFromNothing : kStepsOnward);
}

bool LandmarkWatch::resume(std::vector<KeptReadings> kept) {
  if (std::ranges::any_of(kept, [&](const auto& one) { return one.readings.size() != landmarks_.size(); }))
    return false;
  if (kept.size() > kMostKept) kept.erase(kept.begin(), kept.end() - kMostKept);
  kept_ = std::move(kept);
  if (!kept_.empty()) solve(kept_, kStepsFromNothing);
  return true;
}

std::vector<ChannelExtinctions> LandmarkWatch::estimate_all(const std::vector<std::vector<ContrastReading>>& pictures,
                                                            std::span<const std::size_t> left_out) const {
  // Of an unchanged scene the first is kept for all.
  std::vector<KeptReadings> kept;
  std::vector<std::size_t> place;
  auto asked = pictures;
  for (auto& readings : asked) {
    for (const auto i : left_out)
      if (i < readings.size()) readings[i].usable = false, readings[i].reason = "it is not asked";
    if (kept.empty() || !look_alike(kept.back().readings, readings)) kept.push_back({readings, {}});
    place.push_back(kept.size() - 1);
  }
  auto taught = *this;
  // By colour, only once they are known, it is seen which are in the sun.
  taught.solve(kept, kStepsFromNothing);
  taught.solve(kept, kStepsFromNothing);
  std::vector<ChannelExtinctions> airs;
  for (std::size_t t = 0; t < asked.size(); ++t) {
    taught.believe(place[t]);
    airs.push_back(taught.estimate(asked[t]));
  }
  return airs;
}

ChannelExtinctions LandmarkWatch::with_turbidity(std::array<Extinction, 3> channels, PathAerosol aerosol) const {
  ChannelExtinctions air{std::move(channels), {}, std::move(aerosol), chroma_, tone_};
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

ExtinctionComparison LandmarkWatch::compare(const ChannelExtinctions& air, Turbidity sky, double sky_sigma) const {
  const auto model = [&](double t) {
    return model_extinction_per_m(nodes_, model_, Turbidity{t}, altitude_m_, typical_path_m_).g;
  };
  constexpr double kStep = 1e-3;  // of a numerical derivative by T
  ExtinctionComparison found;
  found.sky_per_m = model(sky.value);
  found.sky_sigma_per_m = sky_sigma * (model(sky.value + kStep) - model(sky.value - kStep)) / (2.0 * kStep);
  const auto& ours = air.extinction();
  if (ours.kind == ExtinctionKind::nothing || !(found.sky_per_m > 0.0)) {
    found.message = ours.reason;
    return found;
  }
  // In logarithms, as air elsewhere has so many times more as less; towards the sky's, our end is two sigma away.
  double off = std::log(ours.per_m / found.sky_per_m);
  // Everything beyond a bound agrees with it.
  if (ours.kind == ExtinctionKind::at_most) off = std::min(0.0, off);
  if (ours.kind == ExtinctionKind::at_least) off = std::max(0.0, off);
  const double end_per_m = off > 0.0 ? ours.lowest_per_m : ours.highest_per_m;
  const double sigma = std::hypot(0.5 * std::log(end_per_m / ours.per_m), found.sky_sigma_per_m / found.sky_per_m);
  if (off != 0.0) found.sigmas = off / sigma;
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
