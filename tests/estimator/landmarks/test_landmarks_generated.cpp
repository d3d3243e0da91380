// Extinction from ridges of generated scenes with known air: several T, suns and landscapes, with camera noise.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/estimator/landmarks/generated_landmarks.hpp"

namespace kasumi {
namespace {

struct Moment {
  double turbidity;
  SunPlace sun;
};
// Towards the sun, across and away from it, high and low.
const std::vector<Moment> kMoments{{1.9, {50, 230}},  {2.4, {68, 30}}, {3.1, {33, 170}},
                                   {4.36, {58, 300}}, {7.0, {45, 80}}, {13.0, {62, 200}}};

struct Score {
  double squares = 0.0, worst = 0.0, relative = 0.0;
  int count = 0;
  void add(const Extinction& found, double truth) {
    const double off = (found.per_m - truth) / found.sigma_per_m;
    squares += off * off;
    worst = std::max(worst, std::abs(off));
    relative += std::abs(found.per_m / truth - 1.0);
    ++count;
  }
};

TEST(LandmarksGenerated, ExtinctionIsTheAirsWithinItsSigma) {
  Score single, together;
  for (const std::uint64_t terrain : {21U, 22U}) {
    const auto view = generated_view(terrain);
    ASSERT_GE(view.landmarks.size(), 6U);
    const LandmarkWatch watch(view.camera.camera, kValley_m, view.landmarks);
    std::vector<std::vector<ContrastReading>> pictures;
    std::uint64_t seed = 100 * terrain;
    for (const auto& moment : kMoments)
      pictures.push_back(watch.read(view.camera.camera, encoded_under(view, moment.turbidity, moment.sun, ++seed)));
    const auto airs = watch.estimate_all(pictures);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const double truth = true_extinction_per_m(view.camera.camera, 1, kMoments[i].turbidity, 5000.0);
      const auto alone = watch.estimate(pictures[i]);
      ASSERT_EQ(alone.extinction().kind, ExtinctionKind::value) << alone.extinction().reason;
      fmt::print("T {:5.2f}: true {:.4f}, alone {:.4f} +- {:.4f}, beside the others {:.4f} +- {:.4f} per km\n",
                 kMoments[i].turbidity, 1e3 * truth, 1e3 * alone.extinction().per_m,
                 1e3 * alone.extinction().sigma_per_m, 1e3 * airs[i].extinction().per_m,
                 1e3 * airs[i].extinction().sigma_per_m);
      single.add(alone.extinction(), truth);
      together.add(airs[i].extinction(), truth);
    }
  }
  constexpr std::string_view kAlone = "alone";
  for (const auto& [score, name] : {std::pair{single, kAlone}, {together, std::string_view("beside the others")}}) {
    fmt::print("{}: errors over sigma rms {:.2f}, worst {:.2f}; mean error {:.1f} %\n", name,
               std::sqrt(score.squares / score.count), score.worst, 100.0 * score.relative / score.count);
    EXPECT_LT(std::sqrt(score.squares / score.count), 1.4) << name;
    EXPECT_GT(std::sqrt(score.squares / score.count), 0.3) << name << ": a sigma that says nothing";
    EXPECT_LT(score.worst, 3.0) << name;
    // A picture by itself does not tell which of its surfaces the sun is on.
    EXPECT_LT(score.relative / score.count, name == kAlone ? 0.2 : 0.15) << name;
  }
}

}  // namespace
}  // namespace kasumi
