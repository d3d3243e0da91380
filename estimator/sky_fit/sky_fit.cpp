#include "estimator/sky_fit/sky_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimator/sky/ground_glow.hpp"
#include "estimator/sky_fit/family_fit.hpp"
#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/sky_patches.hpp"
#include "estimator/sky_fit/unexplained.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kFewestPatches = 8;
// Hosek's T stands for an amount of aerosol of his own: so far it may be from ours.
constexpr double kHosekSigmaAod = 0.03, kHosekSigmaShare = 0.3;
// Sky models that know T alone say of the exponent what they suppose.
constexpr double kSupposedSigmaExponent = 0.4;

std::vector<SkyFamily> families_of(const SkyToFit& sky, const SunDirection& sun) {
  const auto kinds = [&] {
    std::vector<SkyFamily> domes;
    for (const AerosolKind kind : kAerosolKinds)
      if (!sky.known.kind || kind == *sky.known.kind) domes.push_back(SkyFamily::dome(kind, sky.altitude_m, sun));
    return domes;
  };
  if (!sky.every_model) {
    if (sky.hosek) return {SkyFamily::hosek(sky.hosek, sun)};
    if (resolved(sky.model, sky.altitude_m, sky.aerosol.has_value()) == SiteSkyModel::preetham)
      return {SkyFamily::preetham(sun)};
    if (sky.aerosol) return {SkyFamily::dome(sky.aerosol->kind, sky.altitude_m, sun)};
    return kinds();
  }
  std::vector<SkyFamily> all = kinds();
  all.push_back(SkyFamily::preetham(sun));
  if (sky.hosek) all.push_back(SkyFamily::hosek(sky.hosek, sun));
  return all;
}

GivenAir known_of(const SkyToFit& sky) {
  GivenAir known = sky.known;
  if (!sky.every_model && sky.aerosol && !known.angstrom_exponent)
    known.angstrom_exponent = sky.aerosol->angstrom_exponent;
  return known;
}

struct Candidate {
  const SkyFamily* family = nullptr;
  const std::array<Eigen::MatrixXd, 3>* table = nullptr;
  FamilyFit fit;
  double evidence = 0.0, weight = 0.0;
};

// Less likely models are not fitted again; their weight stays what it was against the likeliest.
constexpr double kHopeless = 1e-7;

// -2 ln of a value's probability by its mean square over what was expected. Where that is more, its scale is not known, and
// the probability falls with a power of it; where it is less the dome itself is not exact enough for the difference.
double surprise(double mean_square) {
  return mean_square > 1.0 ? 1.0 + std::log(mean_square) : mean_square;
}

// Fits all that have a weight, and puts the likeliest first.
void weigh(std::vector<Candidate>& candidates, std::span<const Direction> places, const PartsOfLight& measured,
           const Unexplained& unexplained, const GivenAir& known) {
  const double independent = unexplained.independent();
  const auto is_hopeless = [](const Candidate& c) { return c.weight < kHopeless; };
  const double before = candidates.front().evidence;
  double most = -std::numeric_limits<double>::infinity();
  for (Candidate& c : candidates) {
    if (is_hopeless(c)) continue;
    c.fit = WhitenedFamily(*c.family, *c.table, places, measured, unexplained).fitted(known);
    c.evidence = c.fit.log_volume;
    for (int p = 0; p < unexplained.parts(); ++p)
      c.evidence -= 0.5 * independent *
                    surprise(c.fit.part_squares[static_cast<std::size_t>(p)] / static_cast<double>(places.size()));
    most = std::max(most, c.evidence);
  }
  for (Candidate& c : candidates)
    if (is_hopeless(c)) c.evidence += most - before;
  double sum = 0.0;
  for (Candidate& c : candidates) sum += c.weight = std::exp(c.evidence - most);
  for (Candidate& c : candidates) c.weight /= sum;
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.weight > b.weight; });
}

// Of what a gain (one per colour, where there are colours) does not take.
double rms_of(const PartsOfLight& residuals, int parts) {
  const auto n = static_cast<double>(residuals[0].size());
  std::array<double, kLightParts> variance{};
  for (int p = 0; p < parts; ++p) {
    const auto& part = residuals[static_cast<std::size_t>(p)];
    variance[static_cast<std::size_t>(p)] = (part.array() - part.mean()).square().sum() / n;
  }
  // The mean square over red, green and blue.
  return std::sqrt(variance[0] + variance[1] / 6.0 + variance[2] * 2.0 / 9.0);
}

bool is_papers(const SkyFamily& family) {
  return family.name() == "preetham";
}

// Means over models by their weights, and the spread between them.
struct Mixture {
  double weight = 0.0;
  double aod = 0.0, exponent = 0.0, turbidity = 0.0;
  double aod_aod = 0.0, aod_exponent = 0.0, exponent_exponent = 0.0, turbidity_turbidity = 0.0;
};
Mixture mixture_of(const std::vector<SkyModelFit>& models, bool papers) {
  Mixture sum;
  for (const SkyModelFit& model : models) {
    if ((model.answer.name == "preetham") != papers) continue;
    const double w = model.answer.weight, a = model.aerosol.aod_550, e = model.aerosol.angstrom_exponent,
                 t = model.answer.turbidity.value;
    sum.weight += w;
    sum.aod += w * a;
    sum.exponent += w * e;
    sum.turbidity += w * t;
    sum.aod_aod += w * (a * a + model.covariance.aod_550);
    sum.aod_exponent += w * (a * e + model.covariance.aod_and_exponent);
    sum.exponent_exponent += w * (e * e + model.covariance.angstrom_exponent);
    sum.turbidity_turbidity += w * (t * t + model.sigma_turbidity * model.sigma_turbidity);
  }
  if (sum.weight <= 0.0) return sum;
  for (double* value : {&sum.aod, &sum.exponent, &sum.turbidity, &sum.aod_aod, &sum.aod_exponent,
                        &sum.exponent_exponent, &sum.turbidity_turbidity})
    *value /= sum.weight;
  sum.aod_aod -= sum.aod * sum.aod;
  sum.aod_exponent -= sum.aod * sum.exponent;
  sum.exponent_exponent -= sum.exponent * sum.exponent;
  sum.turbidity_turbidity -= sum.turbidity * sum.turbidity;
  return sum;
}

SkyModelFit answer_of(const Candidate& candidate, std::span<const SkyPatch> patches, int parts) {
  const SkyFamily& family = *candidate.family;
  const FamilyFit& fit = candidate.fit;
  const PartsOfLight left = residuals_of(family, fit, patches, *candidate.table);
  SkyModelFit model;
  model.answer = {family.name(), Turbidity{fit.turbidity}, fit.mean.aod_550, rms_of(left, parts), candidate.weight};
  model.kind = family.kind();
  model.aerosol = fit.mean;
  model.covariance = fit.covariance;
  if (!family.kind()) model.covariance.angstrom_exponent = kSupposedSigmaExponent * kSupposedSigmaExponent;
  if (family.name() == "hosek")
    model.covariance.aod_550 += std::pow(kHosekSigmaAod, 2) + std::pow(kHosekSigmaShare * fit.mean.aod_550, 2);
  model.sigma_turbidity = fit.sigma_turbidity;
  model.log_luminance_gain = left[0].mean();
  if (fit.doubts.size() > 0)
    model.ground_albedo = std::clamp(kDomeGroundAlbedo + kSigmaGround * fit.doubts[0], 0.0, 1.0);
  model.at_edge = fit.at_edge;
  return model;
}

}  // namespace

SkyFit fit_sky(std::span<const SkyReading> readings, const SunDirection& sun, const SkyToFit& sky,
               const InstrumentDoubt& doubt) {
  SkyFit result;
  const SkyPatches places(readings, sun);
  if (places.size() < kFewestPatches) return result;
  const std::vector<SkyFamily> families = families_of(sky, sun);
  const GivenAir known = known_of(sky);
  std::vector<std::array<Eigen::MatrixXd, 3>> tables;
  for (const SkyFamily& family : families) tables.push_back(family.log_light(places.centres()));

  const SkyFamily usual = SkyFamily::dome(AerosolKind::continental, sky.altitude_m, sun);
  std::vector<SkyPatch> patches =
      places.gathered(readings, usual.light({usual.place_of(0.1), usual.natural_exponent()}));
  Unexplained unexplained(patches, doubt);
  std::vector<Candidate> candidates;
  for (std::size_t m = 0; m < families.size(); ++m) candidates.push_back({&families[m], &tables[m], {}, 0.0, 1.0});
  weigh(candidates, places.centres(), parts_of(patches), unexplained, known);
  // Once more by what the likeliest model leaves.
  for (int turn = 0; turn < 2; ++turn) {
    const Candidate& best = candidates.front();
    if (turn == 0) patches = places.gathered(readings, best.family->light(best.fit.best));
    unexplained.learn(residuals_of(*best.family, best.fit, patches, *best.table));
    weigh(candidates, places.centres(), parts_of(patches), unexplained, known);
  }

  for (const Candidate& candidate : candidates)
    result.models.push_back(answer_of(candidate, patches, unexplained.parts()));
  result.solved = true;
  result.log_residual = result.models.front().answer.log_residual;
  for (const Candidate& c : candidates) {
    if (is_papers(*c.family)) result.found.papers_share = c.weight;
    if (c.family->kind()) result.found.kinds[static_cast<std::size_t>(*c.family->kind())] = c.weight;
  }
  const double of_kinds = std::accumulate(result.found.kinds.begin(), result.found.kinds.end(), 0.0);
  if (of_kinds > 0.0)
    for (double& kind : result.found.kinds) kind /= of_kinds;
  const bool papers = result.found.papers_share > 0.5;
  const Mixture mixture = mixture_of(result.models, papers);
  const auto likeliest = std::max_element(result.found.kinds.begin(), result.found.kinds.end());
  result.found.aerosol = {mixture.aod, mixture.exponent,
                          kAerosolKinds[static_cast<std::size_t>(likeliest - result.found.kinds.begin())]};
  result.found.covariance = {std::max(0.0, mixture.aod_aod), mixture.aod_exponent,
                             std::max(0.0, mixture.exponent_exponent)};
  result.turbidity = {mixture.turbidity};
  result.sigma_turbidity = std::sqrt(std::max(0.0, mixture.turbidity_turbidity));
  return result;
}

}  // namespace kasumi
