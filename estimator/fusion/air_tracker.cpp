#include "estimator/fusion/air_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/fusion/air_quantities.hpp"
#include "estimator/fusion/seen_column.hpp"
#include "estimator/fusion/seen_path.hpp"

namespace kasumi {
namespace {

constexpr double kLeastRememberedSigma = 0.005;  // of ln amount: a lower bound, whatever a file says
// Chosen: ln aod changes by some .08 in it, less than observers' errors.
constexpr Duration kStillNow = std::chrono::minutes(10);
constexpr double kMostOfWeather = 4.0;  // standard deviations
constexpr double kLeastLasting = 0.01;  // avoids a division by zero where an observer states no lasting error
// Chosen: ln aod changes by .2 in the first hour (AERONET), about an observer's sigma.
constexpr Duration kFollowedFor = std::chrono::hours(1);

GaussMarkov quantities_of(const TrackingRules& options) {
  std::vector<DriftingQuantity> all(kAirQuantities, DriftingQuantity{0.0, 1.0, options.lasting});
  all[kAmount] = options.amount;
  all[kAmount].usual = log_amount(options.given.aod_550.value_or(options.usual_aod_550));
  all[kExponent] = options.exponent;
  all[kNearGround] = options.near_ground;
  if (options.given.any()) {
    all[kExponent].usual = options.given.with(0.0).angstrom_exponent;
    all[kExponent].spread = 0.0;
  }
  if (options.given.aod_550) all[kAmount].spread = all[kNearGround].spread = 0.0;
  return GaussMarkov(std::move(all));
}

std::optional<AerosolKind> given_kind(const GivenAir& given) {
  return given.any() ? std::optional(given.with(0.0).kind) : std::nullopt;
}

}  // namespace

AirTracker::AirTracker(TrackingRules options)
    : options_(std::move(options)),
      state_(quantities_of(options_)),
      errors_(options_.lasting_share),
      kind_(given_kind(options_.given)) {}

GaussMarkov AirTracker::state_at(Instant when) const {
  GaussMarkov state = state_;
  if (seen()) state.advance(passed_between(updated_, when));
  return state;
}

AirTracker::Shown AirTracker::believed(const GaussMarkov& state) const {
  return {state.mean(kAmount), state.mean(kAmount) + state.mean(kNearGround), state.mean(kExponent)};
}

AirTracker::Shown AirTracker::shown_at(Instant when) const {
  const Shown towards = believed(state_at(when));
  if (!seen()) return towards;
  const double reach = options_.largest_rate_per_minute * to_seconds(passed_between(updated_, when)) / 60.0;
  const auto moved = [&](double from, double to) { return from + std::clamp(to - from, -reach, reach); };
  return {moved(shown_.amount, towards.amount), moved(shown_.path_amount, towards.path_amount),
          moved(shown_.exponent, towards.exponent)};
}

double AirTracker::sigmas(double off, const Normal& expected, double passing_sigma) const {
  if (std::abs(off) <= options_.least_gate) return 0.0;
  return std::abs(off) / std::hypot(std::sqrt(expected.variance), passing_sigma);
}

AirTracker::Surprise AirTracker::judge(const Doubt& now, double sigmas, double agree_within, Instant when) {
  if (!seen()) return Surprise::none;
  const auto known = std::ranges::find(doubts_, now.by, &Doubt::by);
  if (sigmas <= options_.gate) {
    if (known != doubts_.end()) doubts_.erase(known);
    return Surprise::none;
  }
  Doubt doubt = now;
  doubt.first = when;
  if (known != doubts_.end()) {
    const bool same = std::abs(now.amount - known->amount) <= std::max(options_.least_gate, agree_within);
    if (same) doubt.count = known->count, doubt.first = known->first;
    doubts_.erase(known);
  }
  ++doubt.count;  // keeps the latest value: the air may still be changing
  const bool changed =
      doubt.count >= options_.agreeing_doubts && passed_between(doubt.first, when) >= options_.doubts_span;
  if (!changed) doubts_.push_back(doubt);
  return changed ? Surprise::agreed : Surprise::doubted;
}

bool AirTracker::contradicted(AirObserver by, double variance, Instant when) const {
  return std::ranges::any_of(last_, [&](const LastReading& one) {
    return one.by != by && one.by != AirObserver::remembered && !one.of_path && one.amount.variance <= variance &&
           passed_between(one.when, when) <= kStillNow;
  });
}

bool AirTracker::followed_in_vain(const Followed& now) {
  // Followed in vain: the distance has shrunk by less than 40 %, though the state moved by less than half of it.
  constexpr double kShrunk = 0.6, kSame = 0.5;
  const auto before = std::ranges::find(followed_, now.by, &Followed::by);
  bool in_vain = false;
  if (before != followed_.end()) {
    in_vain = passed_between(before->when, now.when) <= kFollowedFor && now.off * before->off > 0.0 &&
              std::abs(now.off) > kShrunk * std::abs(before->off) &&
              std::abs(now.amount - before->amount) < kSame * std::abs(now.off);
    followed_.erase(before);
  }
  followed_.push_back(now);
  return in_vain;
}

void AirTracker::bound_near_ground(GaussMarkov& state) const {
  // Of ln near_ground: a soft edge, since the two first moments of a hard one jump.
  constexpr double kEdge = 0.1;
  if (fog_) return;
  GaussMarkov::Row row(kAirQuantities, 0.0);
  row[kNearGround] = 1.0;
  const double least = std::log(options_.least_near_ground), greatest = std::log(options_.greatest_near_ground);
  const Normal before = state.sum(row);
  const double reach = 2.0 * std::sqrt(before.variance);
  if (before.mean - reach > least && before.mean + reach < greatest) return;
  state.condition(row, before, after_observing(before, [&](double there) {
                    return -0.5 * square((there - std::clamp(there, least, greatest)) / kEdge);
                  }));
}

double AirTracker::growth(const std::vector<ObserverPart>& parts) const {
  // Observers differ by 2 sigma in one case of twenty by chance; above, all sigmas grow in proportion, at most
  // fourfold.
  constexpr double kUsualApart = 2.0, kMostGrowth = 4.0;
  double apart = 0.0;
  for (const ObserverPart& one : parts)
    if (one.age <= kStillNow && one.by != AirObserver::remembered) apart = std::max(apart, std::abs(one.apart_sigmas));
  return std::clamp(apart / kUsualApart, 1.0, kMostGrowth);
}

double AirTracker::column_doubt(Instant when) const {
  double variance = square(options_.amount.spread);
  const double drift = square(options_.amount.drift_per_root_hour()) / 3600.0;
  for (const LastReading& one : last_)
    if (!one.of_path)
      variance = std::min(variance, one.amount.variance + drift * to_seconds(passed_between(one.when, when)));
  return variance;
}

void AirTracker::accept(GaussMarkov state, LastingErrors errors, const LastReading& reading) {
  shown_ = seen() ? shown_at(reading.when) : believed(state);
  updated_ = seen() ? std::max(updated_, reading.when) : reading.when;
  seen_ = updated_;
  state_ = std::move(state);
  errors_ = std::move(errors);
  std::erase_if(last_, [&](const LastReading& one) { return one.by == reading.by; });
  last_.push_back(reading);
}

AirTracker::Verdict AirTracker::observe(const ColumnReading& reading, Instant when) {
  GaussMarkov state = state_at(when);
  LastingErrors errors = errors_;
  const auto seen_now = seen_column(reading, state, errors, when);
  if (!seen_now) return Verdict::unusable;
  const auto surprise_of = [&](const SeenSum& one) {
    const Normal expected = state.sum(one.row);
    return sigmas(one.value - expected.mean, expected, one.passing_sigma);
  };
  const Surprise surprise = judge({reading.by, seen_now->amount.mean},
                                  std::max(surprise_of(seen_now->amounts), surprise_of(seen_now->exponents)),
                                  options_.gate * std::sqrt(2.0 * seen_now->amount.variance), when);
  if (surprise == Surprise::doubted) return Verdict::outlier;
  if (surprise == Surprise::agreed) {
    const double off = seen_now->amount.mean - state.mean(kAmount);
    const double exponent_off = seen_now->exponent - state.mean(kExponent);
    const bool in_vain = followed_in_vain({reading.by, seen_now->amount.mean, off, when});
    if (in_vain || contradicted(reading.by, seen_now->amount.variance, when)) {
      // A more certain observer contradicts this one: the air has not changed, so the error is this observer's.
      state.doubt(seen_now->amount_error, square(off) / seen_now->amount.variance);
      state.doubt(seen_now->exponent_error, square(exponent_off / seen_now->exponent_sigma));
    } else {
      state.doubt(kAmount, square(off));
      state.doubt(kExponent, square(exponent_off));
    }
  }
  for (const SeenSum* one : {&seen_now->amounts, &seen_now->exponents})
    state.observe(one->row, one->value, square(one->passing_sigma));
  bound_near_ground(state);
  kind_.observe(reading.found, reading.by != AirObserver::horizon, when);
  accept(std::move(state), std::move(errors), {reading.by, when, false, seen_now->amount});
  return surprise == Surprise::agreed ? Verdict::restarted : Verdict::taken;
}

AirTracker::Verdict AirTracker::observe(const PathReading& reading, Instant when) {
  GaussMarkov state = state_at(when);
  LastingErrors errors = errors_;
  const auto channels = seen_path(reading, options_.altitude_m, state, errors, when);
  if (channels.empty()) return Verdict::unusable;

  const SeenChannel& main = channels.front();
  const double sigma = log_sigma(main.aod, std::hypot(main.sigma, main.shared_sigma));
  const Normal expected = main.sum(state).expected;
  const double off = main.beyond(expected.mean);
  const Surprise surprise = judge({reading.by, log_amount(main.aod)},
                                  sigmas(off, expected, main.passing_share * log_sigma(main.aod, main.sigma)),
                                  options_.gate * std::sqrt(2.0) * sigma, when);
  if (surprise == Surprise::doubted) return Verdict::outlier;
  if (surprise == Surprise::agreed && followed_in_vain({reading.by, log_amount(main.aod), off, when})) {
    for (const SeenChannel& one : channels) state.doubt(one.error, square(off / std::max(kLeastLasting, one.lasting)));
    if (main.lasting_shared > 0.0) state.doubt(kPathError, square(off / std::max(kLeastLasting, main.lasting_shared)));
  } else if (surprise == Surprise::agreed) {
    // Whether the whole column has changed or the path alone, only a look at the sky can say: the column at most as
    // far as the last one and the weather since allow.
    state.doubt(kAmount, std::min(square(off), square(kMostOfWeather) * column_doubt(when)));
    state.doubt(kNearGround, square(off));
    state.doubt(kExponent, square(options_.exponent.spread));
  }
  for (const SeenChannel& one : channels) {
    const auto sum = one.sum(state);
    // A channel that contradicts the others counts for less, not for nothing.
    const double surprising = std::abs(one.beyond(sum.expected.mean)) / std::sqrt(sum.expected.variance);
    const double passing = one.passing_share * one.sigma * std::max(1.0, surprising / options_.gate);
    const Normal after =
        after_observing(sum.expected, [&](double there) { return one.log_likelihood(there, passing); });
    state.condition(sum.row, sum.expected, after);
  }

  fog_ = main.kind != PathReading::Channel::Kind::at_most && main.aod > options_.fog_path_aod;
  bound_near_ground(state);

  // By itself: of a bound, what it leaves of the air as it usually is.
  const double to_550 = std::pow(main.wavelength_nm / 550.0, state.mean(kExponent));
  Normal alone{log_amount(main.aod * to_550), square(sigma)};
  if (main.kind != PathReading::Channel::Kind::value)
    alone = after_observing({state.quantity(kAmount).usual, square(options_.amount.spread)}, [&](double there) {
      return main.log_likelihood(log_amount(aod_of(there) / to_550), std::hypot(main.sigma, main.shared_sigma));
    });
  accept(std::move(state), std::move(errors), {reading.by, when, true, alone});
  return surprise == Surprise::agreed ? Verdict::restarted : Verdict::taken;
}

void AirTracker::remember(const RememberedAir& air, Instant when) {
  const bool read =
      std::ranges::any_of(last_, [](const LastReading& one) { return one.by != AirObserver::remembered; });
  if (read) return;
  const double sigma = std::max(kLeastRememberedSigma, log_sigma(air.aerosol.aod_550, air.sigma_aod_550));
  state_ = quantities_of(options_);
  state_.set(kAmount, {log_amount(air.aerosol.aod_550), square(sigma)});
  state_.set(kExponent, {air.aerosol.angstrom_exponent, square(std::max(kLeastRememberedSigma, air.sigma_angstrom))});
  state_.set(kNearGround,
             {std::log(air.near_ground), square(std::max(kLeastRememberedSigma, air.sigma_log_near_ground))});
  kind_.remember(air.aerosol.kind, air.papers_sky, when);
  shown_ = believed(state_);
  updated_ = when;
  seen_ = when;
  last_ = {{AirObserver::remembered, when, false, {log_amount(air.aerosol.aod_550), square(sigma)}}};
}

std::optional<RememberedAir> AirTracker::to_remember(Instant when, Utc utc) const {
  if (!seen()) return std::nullopt;
  const Shown state = believed(state_);
  RememberedAir air;
  air.aerosol = {aod_of(state.amount), state.exponent, kind_.shown()};
  air.sigma_aod_550 = std::sqrt(state_.variance(kAmount)) * std::exp(state.amount);
  air.sigma_angstrom = std::sqrt(state_.variance(kExponent));
  air.papers_sky = kind_.papers_sky();
  air.near_ground = std::exp(state.path_amount - state.amount);
  air.sigma_log_near_ground = std::sqrt(state_.variance(kNearGround));
  air.utc = utc - std::chrono::duration_cast<Utc::duration>(passed_between(updated_, when));
  return air;
}

}  // namespace kasumi
