// The state of the air over time, from all observers that come and go.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "estimator/fusion/air_observation.hpp"
#include "estimator/fusion/gauss_markov.hpp"
#include "estimator/fusion/kind_belief.hpp"
#include "estimator/fusion/lasting_errors.hpp"
#include "estimator/given_air.hpp"

namespace kasumi {

// One observer's part in the state.
struct ObserverPart {
  AirObserver by = AirObserver::sky;
  Duration age{};        // of its last reading
  double aod_550 = 0.0;  // this observer's own estimate; of the path's extinction as if the column had it
  double sigma_aod_550 = 0.0;
  double share = 0.0;         // 0..1 of what is known now of the air before the object
  double apart_sigmas = 0.0;  // from the state of the others, over both sigmas; 0 where there are no others
};

struct TrackedAir {
  AirState air;                  // shown: changes slowly
  AirState believed;             // which the shown one approaches
  double sigma_turbidity = 0.0;  // of the shown T as today's, including its distance from the estimate
  // Of the estimates of ln near_ground and ln(aod near_ground + small).
  double sigma_log_near_ground = 0.0, sigma_log_path_amount = 0.0;
  bool supposed = false;                // no observer has seen it: as it usually is, or so old that only that is left
  bool trustworthy = false;             // young and certain enough to be called today's air
  Duration age{};                       // since the last reading
  std::vector<ObserverPart> observers;  // the largest share first
  std::array<double, kAerosolKinds.size()> kinds{};  // probability of each
  double papers_share = 0.0;                         // of the sky that the papers' T belongs to
  bool seen() const { return !observers.empty(); }   // or given
  std::string text() const;  // for people: "aerosol .21 +- .03 by sky and landmarks", "the air is supposed: ..."
};

// What is worth keeping over a restart.
struct RememberedAir {
  Aerosol aerosol;
  double sigma_aod_550 = 0.0, sigma_angstrom = 0.0;
  bool papers_sky = false;
  double near_ground = 1.0, sigma_log_near_ground = 0.5;
  Utc utc{};  // of the last reading
  friend bool operator==(const RememberedAir&, const RememberedAir&) = default;
};

// Amounts are in ln(aod_550 + kSmallAerosol).
struct TrackingRules {
  // What it gives is fixed; with the amount, the path's as well (near_ground 1), whatever is seen.
  GivenAir given{};
  double altitude_m = 0.0;  // of the scene camera, for the paths
  // The usual air, assumed without observations, and how the air changes. From AERONET's sites: ln aod varies by .7,
  // and half of it is forgotten within a day; together that is .2 in an hour.
  DriftingQuantity amount{0.0, 0.65, std::chrono::hours(21)};  // `usual` is usual_aod_550
  double usual_aod_550 = 0.15;
  DriftingQuantity exponent{1.3, 0.5, std::chrono::hours(24)};
  DriftingQuantity near_ground{0.0, 0.5, std::chrono::hours(72)};  // ln
  // An observer's error is that of its model, its lens, its landmarks: this share of its variance stays this long.
  double lasting_share = 0.8;
  Duration lasting = std::chrono::hours(6);
  // A reading farther off than this many sigmas, and than the smallest difference, is doubted until this many of the
  // same observer agree over at least this time: then the air has changed. A bird passes quickly, weather does not.
  double gate = 4.0;
  double least_gate = 0.05;
  int agreeing_doubts = 3;
  Duration doubts_span = std::chrono::seconds(20);
  double largest_rate_per_minute = 0.30;  // of what is shown: too slow to be seen as a step
  // Of aerosol mixed over 4 km, and of 300 m of it below an inversion, in units of kAerosolHeight_m. Beyond is fog,
  // which is accepted where the visibility by landmarks is below 2 km: no column holds as much aerosol.
  double least_near_ground = 0.3, greatest_near_ground = 4.0;
  double fog_path_aod = 1.8;
  Duration trusted_for = std::chrono::hours(2);
  double largest_trusted_sigma = 0.35;  // of ln amount
};

// Monotonic time; a time before the last one counts as no time passed.
class AirTracker {
 public:
  explicit AirTracker(TrackingRules options = {});

  // Accepts a reading, or rejects it: not finite, nothing in it, or a lone outlier.
  enum class Verdict { taken, unusable, outlier, restarted };
  Verdict observe(const ColumnReading& reading, Instant when);
  Verdict observe(const PathReading& reading, Instant when);
  // Starts from an earlier state. No effect once there is a reading.
  void remember(const RememberedAir& air, Instant when);

  // The air to show at an instant; does not depend on how often it is called.
  TrackedAir at(Instant when) const;
  // Empty without observations. `utc`: at `when`.
  std::optional<RememberedAir> to_remember(Instant when, Utc utc) const;

 private:
  // What the picture depends on.
  struct Shown {
    double amount = 0.0, path_amount = 0.0, exponent = 0.0;
  };
  struct LastReading {
    AirObserver by;
    Instant when;
    bool of_path;
    Normal amount;  // this observer's own estimate
  };
  struct Doubt {
    AirObserver by;
    double amount = 0.0;
    int count = 0;
    Instant first{};
  };
  enum class Surprise { none, doubted, agreed };
  // An observer was followed to what it read, which was so far off.
  struct Followed {
    AirObserver by;
    double amount = 0.0, off = 0.0;
    Instant when{};
  };

  GaussMarkov state_at(Instant when) const;
  Shown believed(const GaussMarkov& state) const;
  Shown shown_at(Instant when) const;
  // 0 within the smallest difference.
  double sigmas(double off, const Normal& expected, double passing_sigma) const;
  Surprise judge(const Doubt& now, double sigmas, double agree_within, Instant when);
  // Whether a more certain observer has just found the column unchanged.
  bool contradicted(AirObserver by, double variance, Instant when) const;
  // Whether this observer says once more what it was followed to, and is as far off as before: then it errs. Notes that
  // it is followed now.
  bool followed_in_vain(const Followed& now);
  void bound_near_ground(GaussMarkov& state) const;
  // The factor on all sigmas where two current observers differ by more than their sigmas allow.
  double growth(const std::vector<ObserverPart>& parts) const;
  // Variance of ln amount by the last look at the column and the weather since.
  double column_doubt(Instant when) const;
  void accept(GaussMarkov state, LastingErrors errors, const LastReading& reading);
  std::vector<ObserverPart> parts(Instant when) const;
  AirState air_of(const GaussMarkov& state, const Shown& of, double growth) const;
  double sigma_turbidity(const GaussMarkov& state, const Shown& of) const;
  bool seen() const { return seen_.has_value(); }

  TrackingRules options_;
  GaussMarkov state_;  // at updated_
  LastingErrors errors_;
  KindBelief kind_;
  Shown shown_;  // at updated_
  Instant updated_{};
  std::optional<Instant> seen_;  // the last reading, or what was remembered
  std::vector<LastReading> last_;
  std::vector<Doubt> doubts_;
  std::vector<Followed> followed_;
  bool fog_ = false;  // landmarks saw it last
};

}  // namespace kasumi
