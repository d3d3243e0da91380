// The building as one camera sees it, twice: standing in the scene and filmed with it (point spread, noise, sharpening,
// 8 bits, libjpeg), and drawn into the film of the scene without it. What tells them apart is measured as an eye would
// at four times the size: how strong edges are, how much is in the finest detail, how much blocks stand out.
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

Image<double> luma_of(const std::filesystem::path& path) {
  const auto picture = read_photograph(path).value();
  Image<double> luma(picture.encoded.width(), picture.encoded.height());
  std::ranges::transform(picture.encoded.elements(), luma.elements().begin(), [](const glm::vec3& value) {
    return 255.0 * glm::dot(glm::dvec3(0.299, 0.587, 0.114), glm::dvec3(value));
  });
  return luma;
}

// Over the pixels that the building covers wholly, as their neighbours are.
struct Look {
  double edges = 0.0;   // rms of the gradient, of 255
  double finest = 0.0;  // rms of what a binomial mean of 3 x 3 pixels takes away
  double blocks = 0.0;  // mean step across the borders of 8 x 8 blocks, over that elsewhere
};

Look look_of(const Image<double>& luma, const Image<double>& coverage) {
  Look look;
  double pixels = 0.0, at_borders = 0.0, borders = 0.0, inside = 0.0, insides = 0.0;
  for (int y = 1; y + 1 < luma.height(); ++y)
    for (int x = 1; x + 1 < luma.width(); ++x) {
      double around = 0.0, covered = 255.0;
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u) {
          around += (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * luma.at(x + u, y + v);
          covered = std::min(covered, coverage.at(x + u, y + v));
        }
      if (covered < 254.0) continue;
      ++pixels;
      look.edges +=
          (std::pow(luma.at(x + 1, y) - luma.at(x - 1, y), 2) + std::pow(luma.at(x, y + 1) - luma.at(x, y - 1), 2)) /
          4.0;
      look.finest += std::pow(luma.at(x, y) - around, 2);
      const double step = std::abs(luma.at(x + 1, y) - luma.at(x, y));
      (x % 8 == 7 ? at_borders : inside) += step;
      (x % 8 == 7 ? borders : insides) += 1.0;
    }
  look.edges = std::sqrt(look.edges / pixels);
  look.finest = std::sqrt(look.finest / pixels);
  look.blocks = (at_borders / borders) / (inside / insides);
  return look;
}

double error_of(const Image<double>& one, const Image<double>& other, const Image<double>& coverage) {
  double sum = 0.0, weight = 0.0;
  for (std::size_t i = 0; i < one.elements().size(); ++i) {
    sum += coverage.elements()[i] * std::abs(one.elements()[i] - other.elements()[i]);
    weight += coverage.elements()[i];
  }
  return sum / weight;
}

struct Film {
  int quality;
  double spread_px, sharpening;
};

TEST(MatchedCamera, TheDrawnBuildingLooksAsTheFilmedOneDoes) {
  const std::vector<Film> films{{92, 0.6, 0.8}, {75, 0.6, 0.8}, {85, 1.0, 1.5}, {60, 0.5, 0.4}};
  for (const Film& film : figure_cases("cameras", {films[0], films[1]}, films)) {
    auto recipe = small("demo", 1);
    recipe.scene_width = 640;
    recipe.scene_height = 360;
    recipe.truth_frames = 1;
    recipe.filmed_truth = true;
    recipe.jpeg_quality = film.quality;
    recipe.scene_sharpness = {film.spread_px, film.sharpening};
    recipe.scene_quality.reset();
    const auto fixture = recorded(recipe, "matched-camera");
    const auto description = read_text_file(fixture / "fixture.toml").value();
    const auto coverage = luma_of(fixture / "truth/coverage-000000.png");
    const auto filmed = luma_of(fixture / "truth/filmed-000000.jpg");
    const Look real = look_of(filmed, coverage);
    const auto drawn = [&](const std::string& keys) {
      auto text = description;
      text.insert(text.find("[scene.lens]"), keys);
      EXPECT_TRUE(write_text_file(fixture / "fixture.toml", text));
      const auto out = test_folder("matched-camera-out");
      const auto done = replay({fixture, out, false, false, 1, {}});
      EXPECT_TRUE(done) << done.error().message;
      return luma_of(out / "frame-000000.png");
    };
    const std::string noise = "[scene.noise]\nfull_scale_electrons = 10000\nread_electrons = 3\n";
    const std::string blur = fmt::format("point_spread_px = {}\nshared_chroma = true\n", film.spread_px);
    const std::string sharp = fmt::format("sharpening = {}\n", film.sharpening);
    struct Way {
      const char* words;
      std::string keys;
    };
    const std::vector<Way> ways{{"as sharp as pixels are", ""},
                                {"point spread and noise", blur + noise},
                                {"sharpened, too", blur + sharp + noise},
                                {"and in the JPEG's blocks", blur + sharp + "jpeg_blocks = true\n" + noise}};
    const auto camera = fmt::format("JPEG {}, {} px, {}", film.quality, film.spread_px, film.sharpening);
    fmt::print("{}: filmed: edges {:.1f}, finest {:.2f}, blocks {:.2f}\n", camera, real.edges, real.finest,
               real.blocks);
    std::vector<double> errors;
    Look last;
    for (const auto& way : ways) {
      const auto picture = drawn(way.keys);
      last = look_of(picture, coverage);
      errors.push_back(error_of(picture, filmed, coverage));
      fmt::print("  {}: edges {:.2f}, finest {:.2f}, blocks {:.2f} of the filmed; error {:.2f} of 255\n", way.words,
                 last.edges / real.edges, last.finest / real.finest, last.blocks / real.blocks, errors.back());
      figure_row("matched-camera", {fmt::format("{}: {}", camera, way.words), figure_text(last.edges / real.edges, 2),
                                    figure_text(last.finest / real.finest, 2),
                                    figure_text(last.blocks / real.blocks, 2), figure_text(errors.back(), 2)});
    }
    EXPECT_NEAR(last.edges / real.edges, 1.0, 0.05) << camera;
    EXPECT_NEAR(last.finest / real.finest, 1.0, 0.08) << camera;
    EXPECT_NEAR(last.blocks / real.blocks, 1.0, 0.08) << camera;
    EXPECT_LT(errors.back(), errors.front()) << camera;
  }
}

}  // namespace
}  // namespace kasumi
