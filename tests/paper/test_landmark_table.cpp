// Visibility from landmarks beside a measured one: KNMI's meadow at De Bilt.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/paper/landmark_table.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

TEST(LandmarkTable, Prints) {
  const auto folder = shared_data_folder() / "haze/knmi-debilt";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto table = landmark_table(folder, source_folder() / "tests/paper/knmi-debilt.toml");
  ASSERT_TRUE(table) << table.error().message;
  for (const auto& row : table->rows)
    fmt::print("| {} | {:.0f} | {} {:.0f} | {:.0f} | {} |\n", row.frame, row.measured_m, row.kind, row.optical_range_m,
               row.sigma_m, row.within_1_5);
  fmt::print("Spearman {:.3f}\n", table->spearman);
}

}  // namespace
}  // namespace kasumi
