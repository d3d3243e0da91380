#include "estimator/sky_fit/sky_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>

#include "estimator/sky/ground_glow.hpp"
#include "estimator/sky_fit/family_fit.hpp"
#include "estimator/sky_fit/reading_patches.hpp"
#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/unexplained.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kFewestPatches = 8;  // three gains and two numbers of the aerosol need more than five
// The aerosol behind Hosek's T is another than Kasumi's kinds; their amounts may differ by so much.
constexpr double kHosekSigmaAod = 0.03, kHosekSigmaShare = 0.3;
// Sky models that know T alone say of the exponent what they suppose.
constexpr double kSupposedSigmaExponent = 0.4;

// Of the optical depth, what no model knows of air that it was not made of: a quarter of little haze, .02 of more, 8 % of
// much (docs/sky.md: skies of measured particles).
double sigma_of_models(double aod_550) {
  return std::max(std::min(0.25 * aod_550, 0.02), 0.08 * aod_550);
}

std::vector<SkyFamily> families_of(const ModelToFit& sky, const SunDirection& sun) {
  const auto kinds = [&] {
    std::vector<SkyFamily> domes;
    for (const AerosolKind kind : kAerosolKinds)
      if (!sky.known.kind || kind == *sky.known.kind) domes.push_back(SkyFamily::dome(kind, sky.altitude_m, sun));
    return domes;
  };
  if (!sky.every_model) {
    if (sky.hosek) return {SkyFamily::hosek(sky.hosek, sun)};
    if (resolved(sky.model, sky.altitude_m, sky.aerosol.has_value()) == DaylightModel::preetham)
      return {SkyFamily::preetham(sun)};
    if (sky.aerosol) return {SkyFamily::dome(sky.aerosol->kind, sky.altitude_m, sun)};
    return kinds();
  }
  std::vector<SkyFamily> all = kinds();
  all.push_back(SkyFamily::preetham(sun));
  if (sky.hosek) all.push_back(SkyFamily::hosek(sky.hosek, sun));
  return all;
}

GivenAir known_of(const ModelToFit& sky) {
  GivenAir known = sky.known;
  if (!sky.every_model && sky.aerosol && !known.angstrom_exponent)
    known.angstrom_exponent = sky.aerosol->angstrom_exponent;
  return known;
}

struct Candidate {
  SkyFamily family;
  FamilyTables tables;
  std::vector<FamilyPoint> begin;  // where its fit looks first
  FamilyFit fit;
  bool fitted = false;
  double evidence = 0.0, weight = 1.0;
};

// Fine particles beside coarse ones, and two sorts of fine ones: real air is seldom one of the kinds.
// (Polluted air is continental air that absorbs more.)
struct TwoKinds {
  AerosolKind one, other;
};
// A fine kind with a coarse one, and smoke with the other fine ones.
constexpr std::array<TwoKinds, 11> kBlends{{{AerosolKind::continental, AerosolKind::maritime},
                                            {AerosolKind::continental, AerosolKind::desert},
                                            {AerosolKind::continental, AerosolKind::dust},
                                            {AerosolKind::urban, AerosolKind::maritime},
                                            {AerosolKind::urban, AerosolKind::desert},
                                            {AerosolKind::urban, AerosolKind::dust},
                                            {AerosolKind::smoke, AerosolKind::maritime},
                                            {AerosolKind::smoke, AerosolKind::desert},
                                            {AerosolKind::smoke, AerosolKind::dust},
                                            {AerosolKind::smoke, AerosolKind::continental},
                                            {AerosolKind::smoke, AerosolKind::urban}}};

// Of the kinds that were fitted, each beginning between its kinds' own answers.
std::vector<Candidate> blends_of(const std::vector<Candidate>& kinds) {
  std::vector<Candidate> blends;
  const auto of_kind = [&](AerosolKind kind) {
    return std::ranges::find_if(kinds, [&](const Candidate& c) { return c.family.kind() == kind; });
  };
  for (const auto& [one, other] : kBlends) {
    const auto a = of_kind(one), b = of_kind(other);
    if (a == kinds.end() || b == kinds.end()) continue;
    Candidate blend{SkyFamily::blend(a->family, b->family), {a->tables.one, b->tables.one}, {}, {}};
    for (const double share : {0.25, 0.5, 0.75})
      blend.begin.push_back({std::lerp(a->fit.best.place, b->fit.best.place, share),
                             std::lerp(a->fit.best.tilt, b->fit.best.tilt, share), share});
    blends.push_back(std::move(blend));
  }
  return blends;
}

// Less likely models are not fitted again; their weight stays what it was against the likeliest.
constexpr double kHopeless = 1e-3;

// -2 ln of a value's probability by its mean square over what was expected. Where that is more, its scale is not known, and
// the probability falls with a power of it; where it is less the dome itself is not exact enough for the difference.
double surprise(double mean_square) {
  return mean_square > 1.0 ? 1.0 + std::log(mean_square) : mean_square;
}

// What a fit is made to.
struct Measured {
  std::span<const Direction> places;
  RadianceParts light;
  const Unexplained& unexplained;
  const GivenAir& known;
};

void fit_candidate(Candidate& c, const Measured& measured) {
  const Unexplained& unexplained = measured.unexplained;
  WhitenedFamily family(c.family, c.tables, measured.places, measured.light, unexplained);
  // Preetham's and Hosek's skies may have several minima, and cost little.
  c.fit =
      c.fitted && c.family.kind() ? family.fitted_again(measured.known, c.fit) : family.fitted(measured.known, c.begin);
  c.fitted = true;
  c.evidence = c.fit.log_volume;
  for (int p = 0; p < unexplained.parts(); ++p)
    c.evidence -=
        0.5 * unexplained.independent() *
        surprise(c.fit.part_squares[static_cast<std::size_t>(p)] / static_cast<double>(measured.places.size()));
}

// The blends that are nearest before they are fitted: enough to hold the one that would be nearest after.
constexpr std::size_t kBlendsTried = 5;
std::vector<Candidate> nearest_blends(const std::vector<Candidate>& kinds, const Measured& measured) {
  std::vector<Candidate> blends = blends_of(kinds);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < blends.size(); ++i)
    order.emplace_back(
        WhitenedFamily(blends[i].family, blends[i].tables, measured.places, measured.light, measured.unexplained)
            .look(measured.known, blends[i].begin)
            .sum,
        i);
  std::ranges::sort(order);
  std::vector<Candidate> nearest;
  for (std::size_t k = 0; k < std::min(order.size(), kBlendsTried); ++k)
    nearest.push_back(std::move(blends[order[k].second]));
  return nearest;
}

// Weights by the evidence, the likeliest first.
void compare(std::vector<Candidate>& candidates) {
  const double most = std::ranges::max_element(candidates, {}, &Candidate::evidence)->evidence;
  double sum = 0.0;
  for (Candidate& c : candidates) sum += c.weight = std::exp(c.evidence - most);
  for (Candidate& c : candidates) c.weight /= sum;
  std::ranges::stable_sort(candidates, std::ranges::greater{}, &Candidate::weight);
}

// Once more, all that are not hopeless; the rest keep their distance to the likeliest.
void compare_again(std::vector<Candidate>& candidates, const Measured& measured) {
  const double before = candidates.front().evidence;
  double most = -std::numeric_limits<double>::infinity();
  for (Candidate& c : candidates) {
    if (c.weight < kHopeless) continue;
    fit_candidate(c, measured);
    most = std::max(most, c.evidence);
  }
  for (Candidate& c : candidates)
    if (c.weight < kHopeless) c.evidence += most - before;
  compare(candidates);
}

// Of what a gain (one per colour, where there are colours) does not take.
double rms_of(const RadianceParts& residuals, int parts) {
  const auto n = static_cast<double>(residuals[0].size());
  std::array<double, kLightParts> variance{};
  for (int p = 0; p < parts; ++p) {
    const auto& part = residuals[static_cast<std::size_t>(p)];
    variance[static_cast<std::size_t>(p)] = (part.array() - part.mean()).square().sum() / n;
  }
  // The mean square over red, green and blue.
  return std::sqrt(variance[0] + variance[1] / 6.0 + variance[2] * 2.0 / 9.0);
}

bool is_papers(const Candidate& candidate) {
  return candidate.family.name() == "preetham";
}

// Means over models by their weights, and the spread between them.
struct Mixture {
  double weight = 0.0;
  double aod = 0.0, exponent = 0.0, turbidity = 0.0;
  double aod_aod = 0.0, aod_exponent = 0.0, exponent_exponent = 0.0, turbidity_turbidity = 0.0;
};
Mixture mixture_of(std::span<const ModelFit> models, std::span<const Candidate> candidates, bool papers) {
  Mixture sum;
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (is_papers(candidates[i]) != papers) continue;
    const ModelFit& model = models[i];
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

ModelFit answer_of(const Candidate& candidate, std::span<const ReadingPatch> patches, int parts) {
  const SkyFamily& family = candidate.family;
  const FamilyFit& fit = candidate.fit;
  const RadianceParts left = residuals_of(family, fit, patches, candidate.tables);
  ModelFit model;
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

// Kinds by their shares of what is likely. The aerosol's amount and exponent are still to come.
FoundAerosol found_among(std::span<const Candidate> candidates) {
  FoundAerosol found;
  double of_kinds = 0.0;
  for (const Candidate& c : candidates) {
    if (is_papers(c)) found.papers_share = c.weight;
    if (!c.family.kind()) continue;
    of_kinds += c.weight;
    const double share = c.fit.best.share;
    found.kinds[static_cast<std::size_t>(*c.family.kind())] += (1.0 - share) * c.weight;
    if (c.family.other()) found.kinds[static_cast<std::size_t>(*c.family.other())] += share * c.weight;
  }
  if (of_kinds > 0.0)
    for (double& kind : found.kinds) kind /= of_kinds;
  const AerosolKind kind =
      kAerosolKinds[static_cast<std::size_t>(std::ranges::max_element(found.kinds) - found.kinds.begin())];
  found.aerosol.kind = kind;
  // The other kind beside it, where the likeliest blend has it.
  const auto with_it = std::ranges::find_if(candidates, [&](const Candidate& c) {
    return c.family.kind() == kind || (c.family.other() && c.family.other() == kind);
  });
  if (with_it == candidates.end() || !with_it->family.other()) return found;
  const bool is_one = with_it->family.kind() == kind;
  found.aerosol.other = is_one ? *with_it->family.other() : *with_it->family.kind();
  found.aerosol.other_share = is_one ? with_it->fit.best.share : 1.0 - with_it->fit.best.share;
  return found;
}

// What no model knows of the air that it did not make.
void doubt_models(SkyFit& fit) {
  constexpr double kStep = 0.01;  // of a numerical derivative by optical depth
  Aerosol more = fit.found.aerosol;
  more.aod_550 += kStep;
  const double per_aod = (turbidity_of(more) - turbidity_of(fit.found.aerosol)) / kStep;
  const double sigma = sigma_of_models(fit.found.aerosol.aod_550);
  fit.found.covariance.aod_550 += sigma * sigma;
  fit.sigma_turbidity = std::hypot(fit.sigma_turbidity, per_aod * sigma);
}

// The models of the candidates, the likeliest first; of all blends the likeliest stands for all, with their weight.
std::vector<ModelFit> gathered(std::span<const ModelFit> models, std::span<const Candidate> candidates) {
  std::vector<ModelFit> gathered;
  std::optional<std::size_t> blend;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const bool is_blend = candidates[i].family.other().has_value();
    if (is_blend && blend) {
      gathered[*blend].answer.weight += models[i].answer.weight;
      continue;
    }
    if (is_blend) blend = gathered.size();
    gathered.push_back(models[i]);
  }
  std::ranges::stable_sort(gathered, std::ranges::greater{}, [](const ModelFit& m) { return m.answer.weight; });
  return gathered;
}

}  // namespace

SkyFit fit_sky(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
               const InstrumentDoubt& doubt) {
  SkyFit result;
  const ReadingPatches places(readings, sun);
  if (places.size() < kFewestPatches) return result;
  const std::vector<SkyFamily> families = families_of(sky, sun);
  const GivenAir known = known_of(sky);
  std::vector<LightTable> tables;
  for (const SkyFamily& family : families) tables.push_back(family.log_light(places.centres()));

  const SkyFamily usual = SkyFamily::dome(AerosolKind::continental, sky.altitude_m, sun);
  std::vector<ReadingPatch> patches = places.gathered(readings, usual.light({usual.place_of(0.1)}));
  Unexplained unexplained(patches, doubt);
  std::vector<Candidate> candidates;
  for (std::size_t m = 0; m < families.size(); ++m) candidates.push_back({families[m], {&tables[m], nullptr}, {}, {}});
  Measured measured{places.centres(), parts_of(patches), unexplained, known};
  for (Candidate& kind : candidates) fit_candidate(kind, measured);
  for (Candidate& blend : nearest_blends(candidates, measured)) {
    fit_candidate(blend, measured);
    candidates.push_back(std::move(blend));
  }
  compare(candidates);
  // Once more with the likeliest model's residuals.
  for (int turn = 0; turn < 2; ++turn) {
    const Candidate& best = candidates.front();
    if (turn == 0) {
      patches = places.gathered(readings, best.family.light(best.fit.best));
      measured.light = parts_of(patches);
    }
    unexplained.learn(residuals_of(best.family, best.fit, patches, best.tables));
    compare_again(candidates, measured);
  }

  std::vector<ModelFit> models;
  for (const Candidate& candidate : candidates) models.push_back(answer_of(candidate, patches, unexplained.parts()));
  result.models = gathered(models, candidates);
  result.solved = true;
  result.log_residual = result.models.front().answer.log_residual;
  result.found = found_among(candidates);
  const bool papers = result.found.papers_share > 0.5;
  const Mixture mixture = mixture_of(models, candidates, papers);
  result.found.aerosol.aod_550 = mixture.aod;
  result.found.aerosol.angstrom_exponent = mixture.exponent;
  result.found.covariance = {std::max(0.0, mixture.aod_aod), mixture.aod_exponent,
                             std::max(0.0, mixture.exponent_exponent)};
  result.turbidity = {mixture.turbidity};
  result.sigma_turbidity = std::sqrt(std::max(0.0, mixture.turbidity_turbidity));
  const bool by_dome = std::ranges::any_of(result.found.kinds, [](double kind) { return kind > 0.0; });
  if (by_dome && !papers && !known.aod_550) doubt_models(result);
  return result;
}

}  // namespace kasumi
