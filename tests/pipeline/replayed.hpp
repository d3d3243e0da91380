// A recording replayed to the end, and how close its pictures are to the truth.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pipeline/files/photograph_file.hpp"
#include "pipeline/recording/replay.hpp"
#include "tests/figures.hpp"

namespace kasumi {

inline ReplaySummary played(const std::filesystem::path& fixture, const std::filesystem::path& out) {
  const auto summary = replay({fixture, out, false, false, std::nullopt, {}});
  if (!summary) {
    ADD_FAILURE() << summary.error().message;
    return {};
  }
  return *summary;
}

// Mean error of the building's pixels, in levels of 255, against the picture that the slow spectral path draws of the
// same scene. `table`: of a document, in which it is a row.
inline double building_error(const std::filesystem::path& fixture, const std::filesystem::path& out,
                             const std::string& name, const std::string& table = "") {
  const auto picture = read_photograph(out / "frame-000000.png").value();
  const auto truth = read_photograph(fixture / "truth" / "composite-000000.png").value();
  const auto coverage = read_photograph(fixture / "truth" / "coverage-000000.png").value();
  double error = 0.0, weight = 0.0;
  glm::dvec3 bias{};
  for (int y = 0; y < truth.encoded.height(); ++y)
    for (int x = 0; x < truth.encoded.width(); ++x) {
      const double covered = coverage.encoded.at(x, y).r;
      if (covered <= 0.0) continue;
      const auto difference = 255.0 * (glm::dvec3(picture.encoded.at(x, y)) - glm::dvec3(truth.encoded.at(x, y)));
      error += covered * (std::abs(difference.r) + std::abs(difference.g) + std::abs(difference.b)) / 3.0;
      bias += covered * difference;
      weight += covered;
    }
  EXPECT_GT(weight, 500.0) << "the building must be seen";
  bias /= weight;
  fmt::print("{}: mean error over the building {:.2f}/255, bias R {:.2f} G {:.2f} B {:.2f}, {:.0f} pixels\n", name,
             error / weight, bias.r, bias.g, bias.b, weight);
  if (!table.empty())
    figure_row(table, {name, figure_text(error / weight, 1) + " / 255",
                       figure_text(bias.r, 1) + ", " + figure_text(bias.g, 1) + ", " + figure_text(bias.b, 1)});
  return error / weight;
}

}  // namespace kasumi
