// Reports on the tracker's state.
#include <algorithm>
#include <cmath>
#include <functional>

#include "base/aerosol.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/fusion/air_quantities.hpp"
#include "estimator/fusion/air_tracker.hpp"

namespace kasumi {
namespace {

// Below it no ratio of path and column means anything.
constexpr double kLeastColumn = 0.003, kLeastPath = 1e-4;
constexpr double kGivenSigma = 0.005;  // of a log amount, so that it has a weight beside others
// Of the papers' haze: their T says it.
constexpr double kPapersExponent = 1.3;

// The papers' air whose T matches the column and whose extinction near the ground matches the path's estimate at 550
// nm. `known` (0..1): how well the ratio of path and column is known; 0 leaves the extinction that T implies.
AirState papers_air(const Aerosol& aerosol, double path_aod, double known, double altitude_m) {
  constexpr auto kPapers = ScatteringModel::morales2017;  // the papers' own law, M Eq 14-18
  const AirState air(Turbidity{turbidity_of(aerosol)});
  const double seen_per_m = rayleigh_per_m(ScatteringModel::aerosol, 550.0, altitude_m) +
                            path_aod / kAerosolHeight_m * std::exp(-altitude_m / kAerosolHeight_m);
  const double haze_per_m = seen_per_m - rayleigh_per_m(kPapers, 550.0, altitude_m);
  const double usual_per_m = mie_per_m(kPapers, 550.0, air, altitude_m);
  if (known <= 0.0 || usual_per_m <= 0.0) return air;
  return air.with_near_ground(std::pow(std::max(kLeastPath, haze_per_m / usual_per_m), known));
}

double turbidity_slope(double exponent) {
  return turbidity_of({1.0, exponent, {}}) - turbidity_of({0.0, exponent, {}});
}

}  // namespace

std::vector<ObserverPart> AirTracker::parts(Instant when) const {
  struct Part {
    ObserverPart shown;
    bool of_path;
    Normal amount;  // now
  };
  const auto drifted = [&](const LastReading& one) {
    GaussMarkov amount({options_.amount});
    amount.set(0, {0.0, one.amount.variance});
    amount.advance(passed_between(one.when, when));
    return Normal{one.amount.mean, amount.variance(0)};
  };
  std::vector<Part> all;
  for (const LastReading& one : last_) {
    const double sigma = std::sqrt(one.amount.variance);
    all.push_back({{one.by, passed_between(one.when, when), aod_of(one.amount.mean), sigma * std::exp(one.amount.mean)},
                   one.of_path,
                   drifted(one)});
  }
  if (options_.given.aod_550)
    all.push_back({{AirObserver::given, {}, *options_.given.aod_550},
                   false,
                   {log_amount(*options_.given.aod_550), square(kGivenSigma)}});

  const double unlike = square(options_.near_ground.spread);  // of path and column
  double known = 1.0 / square(options_.amount.spread);
  const double relation = state_at(when).variance(kNearGround);
  for (Part& one : all) known += one.shown.share = 1.0 / (one.amount.variance + (one.of_path ? 0.0 : relation));
  for (Part& one : all) {
    one.shown.share /= known;
    double weight = 0.0, mean = 0.0;
    for (const Part& other : all) {
      if (other.shown.by == one.shown.by) continue;
      const double information = 1.0 / (other.amount.variance + (other.of_path != one.of_path ? unlike : 0.0));
      weight += information;
      mean += information * other.amount.mean;
    }
    if (weight > 0.0)
      one.shown.apart_sigmas = (one.amount.mean - mean / weight) / std::sqrt(one.amount.variance + 1.0 / weight);
  }
  std::ranges::sort(all, std::greater{}, [](const Part& one) { return one.shown.share; });
  std::vector<ObserverPart> parts;
  for (const Part& one : all) parts.push_back(one.shown);
  return parts;
}

AirState AirTracker::air_of(const GaussMarkov& state, const Shown& of, double growth) const {
  const auto [other, share] = kind_.beside();
  const Aerosol aerosol{std::min(aod_of(of.amount), kHighestGivenAod),
                        std::clamp(of.exponent, kLowestGivenExponent, kHighestGivenExponent), kind_.shown(), other,
                        share};
  const double path_aod = std::max(kLeastPath, aod_of(of.path_amount));
  if (kind_.papers_sky()) {
    const bool path_seen = std::ranges::any_of(last_, &LastReading::of_path);
    const double left = state.variance(kNearGround) / square(options_.near_ground.spread);
    return papers_air({aerosol.aod_550, kPapersExponent}, path_aod, path_seen ? 1.0 - left : 0.0, options_.altitude_m);
  }
  // As today's: with the distance that is still to go.
  const Shown target = believed(state);
  const double per_log = aerosol.aod_550 + kSmallAerosol;
  const double amount_off = of.amount - target.amount, exponent_off = of.exponent - target.exponent;
  const double grown = square(growth);
  const AerosolCovariance covariance{
      square(per_log) * (grown * state.variance(kAmount) + square(amount_off)),
      per_log * (grown * state.covariance(kAmount, kExponent) + amount_off * exponent_off),
      grown * state.variance(kExponent) + square(exponent_off)};
  const bool as_column = of.path_amount == of.amount;
  return {aerosol, covariance, as_column ? 1.0 : path_aod / std::max(kLeastColumn, aerosol.aod_550)};
}

// Of T by the errors of amount and exponent.
double AirTracker::sigma_turbidity(const GaussMarkov& state, const Shown& of) const {
  const bool papers = kind_.papers_sky();
  const double slope = turbidity_slope(papers ? kPapersExponent : of.exponent), aod = aod_of(of.amount);
  const double by_amount = slope * (aod + kSmallAerosol);
  const double by_exponent = papers ? 0.0 : -slope * aod * std::log(1000.0 / 550.0);
  const double variance = square(by_amount) * state.variance(kAmount) +
                          2.0 * by_amount * by_exponent * state.covariance(kAmount, kExponent) +
                          square(by_exponent) * state.variance(kExponent);
  return std::sqrt(std::max(0.0, variance));
}

TrackedAir AirTracker::at(Instant when) const {
  const GaussMarkov state = state_at(when);
  const Shown shown = shown_at(when);
  TrackedAir tracked;
  tracked.observers = parts(when);
  const double growth = this->growth(tracked.observers);
  tracked.air = air_of(state, shown, growth);
  tracked.believed = air_of(state, believed(state), growth);
  tracked.sigma_turbidity = std::hypot(growth * sigma_turbidity(state, shown),
                                       tracked.air.turbidity().value - tracked.believed.turbidity().value);

  const double column = state.variance(kAmount), relation = state.variance(kNearGround);
  const double path = column + 2.0 * state.covariance(kAmount, kNearGround) + relation;
  tracked.sigma_log_near_ground = growth * std::sqrt(relation);
  tracked.sigma_log_path_amount = growth * std::sqrt(path);

  const double usual = square(options_.amount.spread), usual_path = usual + square(options_.near_ground.spread);
  const bool given = options_.given.aod_550.has_value();
  // More than half forgotten, of the column and of the path.
  tracked.supposed = !given && (!seen() || (column > 0.5 * usual && path > 0.5 * usual_path));
  tracked.age = seen() ? passed_between(*seen_, when) : Duration{0};
  const bool sure = std::sqrt(std::min(column, path)) <= options_.largest_trusted_sigma;
  tracked.trustworthy = given || (seen() && tracked.age <= options_.trusted_for && sure);
  tracked.kinds = kind_.kinds(when);
  tracked.papers_share = kind_.papers_share();
  if (const auto whole = options_.given.whole()) {
    tracked.air = tracked.believed = *whole;
    tracked.sigma_turbidity = 0.0;
    tracked.age = {};
  }
  return tracked;
}

}  // namespace kasumi
