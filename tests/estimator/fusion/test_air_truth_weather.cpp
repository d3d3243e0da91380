// Whether the state's sigma is what it says, over simulated days: what it was told of weather and observers, and what it
// was not.
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/estimator/fusion/simulated_weather.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

using namespace std::chrono;
using test::Erring;
using test::Observer;
using test::TrueAir;

struct Day {
  std::string name;
  Erring sky, landmarks;
  double sky_sigma = 0.1;       // relative, of aod
  double exponent_sigma = 0.2;  // of the sky
  double landmark_sigma = 0.05, landmark_shared = 0.15;
  double weather = 1.0;  // times as quick as the tracker supposes
  std::function<bool(double hour)> sky_seen = [](double) { return true; };
  std::function<bool(double hour)> landmarks_seen = [](double) { return true; };
  double outliers = 0.0;                     // share of readings that see three times as much
  double front = 0.0, front_at_hour = 5.03;  // log amount that comes at once
  double fog = 0.0;                          // log amount that comes to the path alone, an hour later
};

// Sum of squares of error over sigma, by quantity.
struct ChiSquare {
  double amount = 0.0, path = 0.0, exponent = 0.0;
  int count = 0, taken = 0, outliers = 0, restarts = 0;
  double error_path = 0.0, sigma_path = 0.0;
};

void add(ChiSquare& chi, AirTracker::Verdict verdict) {
  chi.taken += verdict == AirTracker::Verdict::taken;
  chi.outliers += verdict == AirTracker::Verdict::outlier;
  chi.restarts += verdict == AirTracker::Verdict::restarted;
}

void live(const Day& day, std::uint64_t seed, ChiSquare& chi) {
  constexpr double kStep_s = 60.0, kHours = 10.0;
  std::mt19937_64 random(seed);
  const TrackingRules options;
  AirTracker tracker;
  test::Wandering amount(random), exponent(random), relation(random);
  Observer sky(day.sky, random), landmarks(day.landmarks, random);
  const double quick = day.weather * day.weather;
  for (double s = 0.0; s < kHours * 3600.0; s += kStep_s) {
    amount.step(kStep_s, to_seconds(options.amount.memory) / quick, random);
    exponent.step(kStep_s, to_seconds(options.exponent.memory) / quick, random);
    relation.step(kStep_s, to_seconds(options.near_ground.memory) / quick, random);
    sky.step(kStep_s, random);
    landmarks.step(kStep_s, random);
    const double hour = s / 3600.0;
    const double front = hour > day.front_at_hour ? day.front : 0.0;
    const double fog = hour > day.front_at_hour + 1.0 ? day.fog : 0.0;
    const TrueAir truth{
        std::log(options.usual_aod_550 + kSmallAerosol) + options.amount.spread * amount.value() + front,
        options.exponent.usual + options.exponent.spread * exponent.value(),
        options.near_ground.spread * relation.value() + fog};
    const Instant when{from_seconds(s)};
    const auto odd = [&] { return std::uniform_real_distribution<>()(random) < day.outliers ? 3.0 : 1.0; };
    if (day.sky_seen(hour)) {
      const double sigma = 0.01 + day.sky_sigma * truth.aod();
      add(chi, tracker.observe(
                   test::column_reading(odd() * truth.aod() + sigma * sky.error(0, random), sigma,
                                        truth.exponent + day.exponent_sigma * sky.error(1, random), day.exponent_sigma),
                   when));
    }
    if (day.landmarks_seen(hour))
      add(chi, tracker.observe(
                   test::path_reading(odd() * truth.path_aod(), truth.exponent, day.landmark_sigma, day.landmark_shared,
                                      {landmarks.error(0, random), landmarks.error(1, random),
                                       landmarks.error(2, random), landmarks.lasting(3)}),
                   when));
    if (std::fmod(hour, 0.5) > 1e-3) continue;
    const TrackedAir air = tracker.at(when);
    const AirState& believed = air.believed;
    const double aod = believed.aerosol().aod_550;
    const auto square = [](double x) { return x * x; };
    chi.amount += square(std::log((truth.aod() + kSmallAerosol) / (aod + kSmallAerosol))) /
                  (believed.covariance().aod_550 / square(aod + kSmallAerosol));
    chi.exponent +=
        square(truth.exponent - believed.aerosol().angstrom_exponent) / believed.covariance().angstrom_exponent;
    const double path_off = truth.path_amount() - std::log(aod * believed.near_ground() + kSmallAerosol);
    chi.path += square(path_off) / square(air.sigma_log_path_amount);
    chi.error_path += square(path_off);
    chi.sigma_path += square(air.sigma_log_path_amount);
    ++chi.count;
  }
}

TEST(AirTruthWeather, SigmaIsHonestOverDays) {
  const auto always = [](double) { return true; };
  const auto never = [](double) { return false; };
  const auto clouds = [](double hour) { return hour < 3.0 || hour > 8.0; };
  const Erring constant{0.95, 1e9}, quick{0.5, 1800.0};
  const std::vector<Day> days{
      {"as supposed: sky and landmarks", {}, {}},
      {"sky alone", {}, {}, .1, .2, .05, .15, 1.0, always, never},
      {"landmarks alone", {}, {}, .1, .2, .05, .15, 1.0, never, always},
      {"clouds from 3 to 8 h", {}, {}, .1, .2, .05, .15, 1.0, clouds, always},
      {"the same without landmarks", {}, {}, .1, .2, .05, .15, 1.0, clouds, never},
      {"errors that never change", constant, constant},
      {"errors of half an hour, half of them", quick, quick},
      {"poor observers", {}, {}, .4, .5, .15, .4},
      {"sky exact", {}, {}, .02, .05, .1, .3},
      {"weather twice as quick", {}, {}, .1, .2, .05, .15, 1.41},
      {"weather half as quick", {}, {}, .1, .2, .05, .15, 0.71},
      {"nobody", {}, {}, .1, .2, .05, .15, 1.0, never, never},
      {"a fiftieth of the readings wrong", {}, {}, .1, .2, .05, .15, 1.0, always, always, .02},
      {"a front: three times less", {}, {}, .1, .2, .05, .15, 1.0, always, always, 0.0, -1.1},
      {"fog on the path", {}, {}, .1, .2, .05, .15, 1.0, always, always, 0.0, 0.0, 5.0, 2.0},
      {"fog on the path under clouds", {}, {}, .1, .2, .05, .15, 1.0, clouds, always, 0.0, 0.0, 5.0, 2.0},
  };
  std::printf("%-40s %8s %8s %8s | %8s %8s | %7s %6s %8s\n", "chi^2 a degree of freedom of", "column", "path",
              "exponent", "rms path", "sigma", "taken", "doubt", "restart");
  const std::uint64_t days_each = whole_figures() ? 120 : 30;
  std::printf("%d days each\n", static_cast<int>(days_each));
  for (const Day& day : days) {
    ChiSquare chi;
    for (std::uint64_t seed = 1; seed <= days_each; ++seed) live(day, seed, chi);
    const double n = chi.count;
    std::printf("%-40s %8.2f %8.2f %8.2f | %8.3f %8.3f | %7d %6d %8d\n", day.name.c_str(), chi.amount / n, chi.path / n,
                chi.exponent / n, std::sqrt(chi.error_path / n), std::sqrt(chi.sigma_path / n), chi.taken, chi.outliers,
                chi.restarts);
    for (const double value : {chi.amount, chi.path, chi.exponent}) {
      EXPECT_GT(value / n, 0.5) << day.name;
      EXPECT_LT(value / n, 2.0) << day.name;
    }
  }
}

}  // namespace
}  // namespace kasumi
