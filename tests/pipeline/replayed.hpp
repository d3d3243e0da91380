// A recording replayed to the end, and how close its pictures are to the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
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

// Each pixel as the mean of the `side` x `side` pixels around it that lie in the picture.
template <class Pixel>
Image<Pixel> means_over(const Image<Pixel>& image, int side) {
  if (side <= 1) return image;
  Image<Pixel> means(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      Pixel sum{0.0F};
      int met = 0;
      for (int v = std::max(0, y - side / 2); v <= std::min(image.height() - 1, y + side / 2); ++v)
        for (int u = std::max(0, x - side / 2); u <= std::min(image.width() - 1, x + side / 2); ++u, ++met)
          sum += image.at(u, v);
      means.at(x, y) = sum / static_cast<float>(met);
    }
  return means;
}

// Mean error of the building's pixels, in levels of 255, against the picture that the slow spectral path draws of the
// same scene. `table`: of a document, in which it is a row. `mean_over_px`: compared are means over so many pixels each
// way, for a camera whose noise and JPEG are drawn, too.
inline double building_error(const std::filesystem::path& fixture, const std::filesystem::path& out,
                             const std::string& name, const std::string& table = "", int mean_over_px = 1) {
  auto picture = read_photograph(out / "frame-000000.png").value();
  auto truth = read_photograph(fixture / "truth" / "composite-000000.png").value();
  for (auto* shown : {&picture, &truth}) shown->encoded = means_over(shown->encoded, mean_over_px);
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
