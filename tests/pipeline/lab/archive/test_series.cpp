// Trends by monthly values, and what became of each month's pictures.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/lab/archive/series_figures.hpp"
#include "pipeline/lab/archive/summary_page.hpp"
#include "pipeline/lab/archive/trend.hpp"
#include "tests/browser.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

struct MadeSeries {
  int months = 120;
  double per_year = -0.004, of_next = 0.4, sigma = 0.03;
  double known = 0.8;  // share of months
  std::vector<MonthlyValue> values(unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<MonthlyValue> all;
    double rest = sigma * normal(random);
    for (int month = 0; month < months; ++month) {
      if (month > 0) rest = of_next * rest + std::sqrt(1.0 - of_next * of_next) * sigma * normal(random);
      const double season = 0.05 * std::sin(2.0 * std::numbers::pi * (month - 2) / 12.0);
      if (uniform(random) < known) all.push_back({24240 + month, 0.2 + per_year * month / 12.0 + season + rest});
    }
    return all;
  }
};

struct Coverage {
  double within = 0.0, mean = 0.0, mean_next = 0.0;
};
Coverage coverage_of(const MadeSeries& made, int trials) {
  Coverage coverage;
  for (int trial = 0; trial < trials; ++trial) {
    const auto trend = trend_of(made.values(static_cast<unsigned>(trial) + 1));
    EXPECT_TRUE(trend);
    coverage.within += std::abs(trend->per_year - made.per_year) <= trend->sigma ? 1.0 / trials : 0.0;
    coverage.mean += trend->per_year / trials;
    coverage.mean_next += trend->autocorrelation / trials;
  }
  return coverage;
}

// Of a right sigma 68 % of the trends are within one; of 300 trials 58 to 78 % are.
TEST(Trend, SigmaIsTheScatterOfTrendsUnderAutocorrelation) {
  for (const double of_next : {0.0, 0.4, 0.7}) {
    MadeSeries made;
    made.of_next = of_next;
    const auto coverage = coverage_of(made, 300);
    EXPECT_GT(coverage.within, 0.58) << of_next;
    EXPECT_LT(coverage.within, 0.78) << of_next;
    EXPECT_NEAR(coverage.mean, made.per_year, 0.0008) << of_next;
    EXPECT_NEAR(coverage.mean_next, of_next, 0.08) << of_next;
    ::testing::Test::RecordProperty(fmt::format("within_{}", of_next), fmt::format("{:.3f}", coverage.within));
  }
}

// Weatherhead 1998, equation 2: for many years without gaps.
TEST(Trend, SigmaIsWeatherheadsInALongSeries) {
  MadeSeries made;
  made.months = 360;
  made.known = 1.1;
  const auto trend = trend_of(made.values(1)).value();
  const double next = trend.autocorrelation;
  const double theirs = trend.sigma_month / std::pow(30.0, 1.5) * std::sqrt((1.0 + next) / (1.0 - next));
  EXPECT_NEAR(trend.sigma / theirs, 1.0, 0.1);
}

TEST(Trend, TooFewMonthsHaveNone) {
  MadeSeries made;
  made.months = 30;
  made.known = 1.1;
  EXPECT_THAT(trend_of(made.values(1)).error().message,
              HasSubstr("30 months are known within 30: expected at least 24 within 36"));
  EXPECT_FALSE(trend_of({}));
}

nlohmann::json record(const char* utc, const char* verdict, const char* sky, const char* refused) {
  nlohmann::json made{{"utc", utc}, {"verdict", verdict}, {"sky", sky}, {"refused", nullptr}};
  if (*refused) made["refused"] = refused;
  return made;
}

TEST(SeriesFigures, SayWhatBecameOfAMonthsPictures) {
  SeriesFigures series(60min);
  series.add(record("2025-05-31T23:30:00Z", "clear", "clear", ""));
  series.add(record("2025-06-02T10:00:00Z", "overcast", "overcast", "overcast"));
  series.add(record("2025-06-02T11:00:00Z", "partly cloudy", "broken", "too little clear sky"));
  series.add(record("2025-06-02T05:00:00Z", "sun too low", "clear", "sun too low"));
  series.add(record("2025-06-02T06:00:00Z", "unknown", "clear", "nothing fits"));
  auto moon = record("2025-06-02T23:00:00Z", "clear", "clear", "");
  moon["sun_zenith_deg"] = 101.0;
  series.add(moon);
  ASSERT_EQ(series.months().size(), 1u);
  const auto& [number, month] = *series.months().begin();
  EXPECT_EQ(number, 2025 * 12 + 5);
  EXPECT_EQ(month.count(EstimateFate::air_known), 1u);
  EXPECT_EQ(month.count(EstimateFate::cloudy), 2u);
  EXPECT_EQ(month.count(EstimateFate::sun_too_low), 1u);
  EXPECT_EQ(month.count(EstimateFate::other), 1u);
  EXPECT_EQ(month.count(EstimateFate::night), 1u);
  EXPECT_EQ(month.pictures(), 6u);
}

// A picture of the moonlit sky is no air, whatever the fit made of it.
TEST(SeriesFigures, NightsAreLeftOutByRule) {
  ArchiveFigures figures(0h);
  figures.add({{"utc", "2025-06-02T23:00:00Z"}, {"refused", nullptr}, {"aod_550", 3.0}, {"sun_zenith_deg", 101.0}});
  EXPECT_EQ(figures.usable(), 0u);
  EXPECT_EQ(figures.nights(), 1u);
  EXPECT_EQ(figures.days().begin()->second.aods(), 0u);
}

// Twelve years of a camera that was moved in the sixth, beside a photometer.
class SeriesPage : public testing::Test {
 protected:
  void SetUp() override {
    made.months = 144;
    made.known = 1.1;
    std::vector<PhotometerReading> readings;
    for (const auto& [month, value] : made.values(7))
      for (int day = 1; day <= 5; ++day)
        readings.push_back({*parse_utc(time_of(month, day)), value + 0.01 * (day - 3) - 0.02});
    photometer.emplace(readings);
    for (const auto& [month, value] : made.values(7))
      for (int day = 1; day <= 5; ++day) {
        nlohmann::json each = record(time_of(month, day).c_str(), "clear", "clear", "");
        each["aod_550"] = value;
        each["sun_seen"]["disagreement_deg"] = month < 24240 + 72 ? 0.4 : 3.1;
        each["circle"] = {240.0, 240.0, 232.0 - 0.1 * month / 12};
        figures.add(each);
        series.add(each);
        photometer->add(each);
        const auto cloudy =
            record((time_of(month, day).substr(0, 11) + "14:00:00Z").c_str(), "overcast", "overcast", "overcast");
        figures.add(cloudy);
        series.add(cloudy);
      }
  }
  static std::string time_of(int month, int day) {
    return fmt::format("{:04}-{:02}-{:02}T10:00:00Z", month / 12, month % 12 + 1, day);
  }
  MadeSeries made;
  ArchiveFigures figures{0h};
  SeriesFigures series{0h};
  std::optional<PhotometerComparison> photometer;
  const Archive archive{1, "0123456789abcdef", "fedcba9876543210"};
};

TEST_F(SeriesPage, HoldsTrendWeatherPhotometerAndDrift) {
  const ArchiveSummary summary{figures, series, &*photometer, archive};
  const auto page = summary_page(summary);
  EXPECT_THAT(page, AllOf(HasSubstr("<h2>Trend</h2>"), HasSubstr("Weatherhead 1998"),
                          HasSubstr("<h2>Gaps by weather</h2>"), HasSubstr("2026-02: 3.10"),
                          HasSubstr("degrees between the sun seen"), HasSubstr("bias +0.020, RMSE 0.024")));
  const auto json = parse_json(summary_json(summary));
  const double per_year = json["trend_aod_550"]["per_year"], sigma = json["trend_aod_550"]["sigma_per_year"];
  EXPECT_NEAR(per_year, made.per_year, 3.0 * sigma);
  EXPECT_THAT(page, HasSubstr(fmt::format("changes by {:+.4f} &#177; {:.4f} a year", per_year, sigma)));
  EXPECT_NEAR(json["months"].front()["sun_off_deg"], 0.4, 1e-6);
  EXPECT_EQ(json["months"].front()["cloudy"], 5);
  EXPECT_EQ(json["photometer"]["pairs"], json["photometer"]["readings"]);
  const auto alone = summary_page({figures, series, nullptr, archive});
  EXPECT_THAT(alone, testing::Not(HasSubstr("photometer</h2>")));
}

TEST_F(SeriesPage, ABrowserFindsItAccessible) {
  if (!std::filesystem::exists("/usr/bin/chromium")) GTEST_SKIP() << "chromium is not installed";
  if (!std::filesystem::exists(axe_core())) GTEST_SKIP() << "axe-core is not there: ./bootstrap browser";
  const auto folder = test_folder("series-page");
  std::filesystem::create_directories(folder);
  const auto result = seen_by_axe(folder, summary_page({figures, series, &*photometer, archive}));
  ASSERT_TRUE(result.is_object());
  EXPECT_GT(result["passes"], 15) << "the rules did not run";
  EXPECT_EQ(result["violations"].dump(), "[]");
  EXPECT_LE(result["wide"], 0) << "it must not scroll sideways";
}

}  // namespace
}  // namespace kasumi
