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
#include "tests/must.hpp"

namespace kasumi {

inline ReplaySummary played(const std::filesystem::path& fixture, const std::filesystem::path& out) {
  return *must(replay({fixture, out, false, false, std::nullopt, {}}));
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

// Over the pixels that the building covers, each by the share that it covers, in levels of 255.
struct CoveredDifference {
  double mean = 0.0;    // of the channels' absolute differences
  glm::dvec3 bias{};    // one minus other
  double pixels = 0.0;  // covered
  double worst_bias() const { return std::max({std::abs(bias.r), std::abs(bias.g), std::abs(bias.b)}); }
};
inline CoveredDifference covered_difference(const Image<glm::vec3>& one, const Image<glm::vec3>& other,
                                            const Image<glm::vec3>& coverage) {
  CoveredDifference found;
  for (std::size_t i = 0; i < coverage.elements().size(); ++i) {
    const double covered = coverage.elements()[i].r;
    const auto off = 255.0 * (glm::dvec3(one.elements()[i]) - glm::dvec3(other.elements()[i]));
    found.mean += covered * (std::abs(off.r) + std::abs(off.g) + std::abs(off.b)) / 3.0;
    found.bias += covered * off;
    found.pixels += covered;
  }
  found.mean /= found.pixels;
  found.bias /= found.pixels;
  return found;
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
  const auto [error, bias, pixels] = covered_difference(picture.encoded, truth.encoded, coverage.encoded);
  EXPECT_GT(pixels, 500.0) << "the building must be seen";
  fmt::print("{}: mean error over the building {:.2f}/255, bias R {:.2f} G {:.2f} B {:.2f}, {:.0f} pixels\n", name,
             error, bias.r, bias.g, bias.b, pixels);
  if (!table.empty())
    figure_row(table, {name, figure_text(error, 1) + " / 255",
                       figure_text(bias.r, 1) + ", " + figure_text(bias.g, 1) + ", " + figure_text(bias.b, 1)});
  return error;
}

}  // namespace kasumi
