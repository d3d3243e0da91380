// The papers' tables on generated skies: 8-bit sRGB, 500 x 500, sun zenith 58.4 deg, N = 100, 100 repeats, T 2..9.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "estimator/papers/reference_pixel.hpp"
#include "tests/estimator/turbidity/estimate_often.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

constexpr int kRepeats = 100;

// A quarter of the figure runs as many repeats, so that means and deviations are as accurate, for fewer turbidities.
std::vector<int> turbidities(const std::vector<int>& worst) {
  return figure_cases("turbidities", worst, {2, 3, 4, 5, 6, 7, 8, 9});
}

using Row = test::Repeated;
Row estimate_often(const test::SyntheticSky& description, const EstimateParameters& options,
                   double sun_error_deg = 0.0) {
  return test::estimate_often(description, options, kRepeats, sun_error_deg);
}

void print_head(const char* title) {
  std::printf(
      "\n%s, %d repeats\n  T |     M Table 1      |      Kasumi        | bound  sigma/bound | stated | worst  | "
      "usable\n",
      title, kRepeats);
}
void print_row(const char* table, int t, const Row& row) {
  figure_row(table, {fmt::format("{}", t),
                     fmt::format("{:.3f} +- ", test::kMoralesTable1[t - 2][0]) +
                         figure_text(test::kMoralesTable1[t - 2][1], 3),
                     fmt::format("{:.4f} +- ", row.mean) + figure_text(row.sigma, 4),
                     figure_text(row.sigma / row.bound, 2), figure_text(row.worst, 3)});
  std::printf("  %d | %8.4f +- %6.4f | %8.4f +- %6.4f | %6.4f   %5.2f      | %6.4f | %6.4f | %d\n", t,
              test::kMoralesTable1[t - 2][0], test::kMoralesTable1[t - 2][1], row.mean, row.sigma, row.bound,
              row.sigma / row.bound, row.stated, row.worst, row.usable);
}

TEST(TurbidityTables, ClearSkiesAreUnbiasedAndAtTheBound) {
  print_head("clear skies");
  for (const int t : turbidities({4, 9})) {
    const Row row = estimate_often({.turbidity = static_cast<double>(t)}, {});
    print_row("turbidity-clear", t, row);
    EXPECT_EQ(row.usable, kRepeats);
    EXPECT_LE(std::abs(row.mean - t), 0.005) << t;
    EXPECT_LE(row.sigma, 1.2 * row.bound) << t;
  }
}

TEST(TurbidityTables, ThirtyPerCentCloudsCostLittle) {
  print_head("30 % clouds");
  for (const int t : turbidities({4, 8})) {
    const Row row = estimate_often({.turbidity = static_cast<double>(t), .cloud_cover = 0.3, .cloud_seed = 5}, {});
    print_row("turbidity-clouds-30", t, row);
    EXPECT_EQ(row.usable, kRepeats);
    EXPECT_LE(std::abs(row.mean - t), 0.005) << t;
    EXPECT_LE(row.sigma, 1.4 * row.bound) << t;
  }
}

TEST(TurbidityTables, FiftyPerCentConnectedCloudsCostATenthAtWorst) {
  print_head("50 % connected clouds");
  for (const int t : turbidities({7, 9})) {
    const Row row = estimate_often({.turbidity = static_cast<double>(t), .cloud_cover = 0.5, .cloud_seed = 6}, {});
    print_row("turbidity-clouds-50", t, row);
    EXPECT_EQ(row.usable, kRepeats);
    EXPECT_LE(row.worst, 0.1) << t;
  }
}

// M14 Table 2: error of the mean at T = 2, beside Zhao's.
TEST(TurbidityTables, AWrongSunCostsLessThanInMorales2014) {
  std::printf("\nsun off by | M14 Table 2 | Zhao | Kasumi (T +- sigma, usable)\n");
  const auto rows = figure_cases<int>("errors of the sun", {2}, {0, 1, 2});
  for (const int row_of_table : rows) {
    const auto& [degrees, morales, zhao] = test::kMorales2014Table2[row_of_table];
    const Row row = estimate_often({.turbidity = 2.0}, {}, degrees);
    const double error = 100.0 * std::abs(row.mean - 2.0) / 2.0;
    std::printf("  %4.0f deg | %8.2f %%  | %2.0f %% | %.2f %% (%.4f +- %.4f, %d)\n", degrees, morales, zhao, error,
                row.mean, row.sigma, row.usable);
    figure_row("turbidity-wrong-sun",
               {fmt::format("{:.0f} deg", degrees), figure_text(morales, 2) + " %", figure_text(error, 2) + " %",
                fmt::format("{} of {}", kRepeats - row.usable, kRepeats)});
    EXPECT_LT(error, morales);
    EXPECT_GE(row.usable, 80);
  }
}

// The papers' own form stays within the errors that M Table 1 shows for it: up to 6 %.
TEST(TurbidityTables, TheReferencePixelFormReproducesThePapersErrors) {
  print_head("reference pixel (M Eq 8), no cloud mask");
  EstimateParameters options;
  options.mask_clouds = false;
  options.solve = by_reference_pixel({.rounds = 12});
  for (const int t : turbidities({4, 9})) {
    const Row row = estimate_often({.turbidity = static_cast<double>(t)}, options);
    print_row("turbidity-reference-pixel", t, row);
    EXPECT_GE(row.usable, 0.95 * kRepeats);
    EXPECT_LE(std::abs(row.mean - t), 0.06 * t);
    EXPECT_GT(row.sigma, row.bound) << "one reference pixel cannot be as good as a free gain";
  }
}

}  // namespace
}  // namespace kasumi
