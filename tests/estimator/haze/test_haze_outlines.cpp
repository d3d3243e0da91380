// Ragged outlines of a range map are moved to the picture's edges, and haze shows them no more.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/haze/haze_picture.hpp"
#include "estimator/haze/outlines.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

constexpr int kWide = 240, kTall = 160, kReach = 8;
constexpr float kNear = 0.35F, kFar = 1.0F;

// Smooth, of about -1 .. 1, no faster than some pixels.
double wander(double t, double phase) {
  return 0.55 * std::sin(0.31 * t + phase) + 0.3 * std::sin(0.83 * t + 2.0 * phase) + 0.25 * std::sin(1.7 * t + phase);
}

struct OutlineScene {
  Image<glm::vec3> picture;
  Image<float> range, ragged;  // as it is; as a stereo camera sees it
};

// A round thing and a post of 5 pixels before a wall; all three with texture of their own.
OutlineScene outline_scene(double raggedness_px) {
  OutlineScene made{Image<glm::vec3>(kWide, kTall), Image<float>(kWide, kTall), Image<float>(kWide, kTall)};
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x) {
      const auto in_front = [&](double grown, double moved) {
        return std::hypot(x - 90.0, y - 80.0) < 45.0 + grown || std::abs(x - 190.0 - moved) < 2.5 + 0.5 * grown;
      };
      const double angle = std::atan2(y - 80.0, x - 90.0);
      const bool near = in_front(0.0, 0.0);
      const bool seen_near = in_front(raggedness_px * wander(45.0 * angle, 1.0), 0.3 * raggedness_px * wander(y, 2.0));
      made.range.at(x, y) = near ? kNear : kFar;
      made.ragged.at(x, y) = seen_near ? kNear : kFar;
      const float texture = 0.03F * static_cast<float>(wander(3.1 * x, 0.3 * y));
      made.picture.at(x, y) =
          near ? glm::vec3(0.55F, 0.18F, 0.14F) + texture : glm::vec3(0.35F, 0.42F, 0.45F) + texture;
    }
  return made;
}

double wrong_share(const Image<float>& range, const Image<float>& truth) {
  double wrong = 0.0;
  for (std::size_t i = 0; i < range.elements().size(); ++i)
    wrong += std::abs(range.elements()[i] - truth.elements()[i]) > 0.1F ? 1.0 : 0.0;
  return wrong / static_cast<double>(range.elements().size());
}

// rms over all pixels of the picture in haze, against the one by the true ranges.
double error_in_haze(const OutlineScene& scene, const Image<float>& range) {
  const auto hazed = [&](const Image<float>& by) {
    HazeRange made;
    made.range = by;
    made.steps_along_row = made.steps_down_column = Image<float>(kWide, kTall);
    return under_haze(scene.picture, made, haze_optics(0.1, 1.2, 6.0), glm::dvec3(0.75), DiffusionScheme::matched)
        .value()
        .light;
  };
  const auto truth = hazed(scene.range), found = hazed(range);
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.elements().size(); ++i) {
    const auto off = truth.elements()[i] - found.elements()[i];
    sum += static_cast<double>(off.r * off.r + off.g * off.g + off.b * off.b) / 3.0;
  }
  return std::sqrt(sum / static_cast<double>(truth.elements().size()));
}

TEST(HazeOutlines, AreMovedToThePicturesEdges) {
  for (const double raggedness_px : {2.0, 4.0, 6.0}) {
    const auto scene = outline_scene(raggedness_px);
    auto moved = scene.ragged;
    move_outlines_to_edges(scene.picture, moved, kReach);
    const double before = wrong_share(scene.ragged, scene.range), after = wrong_share(moved, scene.range);
    const double haze_before = error_in_haze(scene, scene.ragged), haze_after = error_in_haze(scene, moved);
    fmt::print("ragged by {} px: {:.2f} % of the picture wrong, {:.2f} % after; in haze rms {:.4f}, {:.4f} after\n",
               raggedness_px, 100.0 * before, 100.0 * after, haze_before, haze_after);
    figure_row("haze-outlines",
               {figure_text(raggedness_px, 0), figure_text(100.0 * before, 1), figure_text(100.0 * after, 1),
                figure_text(haze_before, 4), figure_text(haze_after, 4)});
    EXPECT_LE(after, 0.15 * before) << raggedness_px;
    EXPECT_LE(haze_after, 0.55 * haze_before) << raggedness_px;
  }
}

TEST(HazeOutlines, ThatAreRightStay) {
  const auto scene = outline_scene(0.0);
  auto moved = scene.range;
  move_outlines_to_edges(scene.picture, moved, kReach);
  EXPECT_LE(wrong_share(moved, scene.range), 0.0005);
}

TEST(HazeOutlines, AwayFromStepsAndWithoutReachNothingChanges) {
  const auto scene = outline_scene(4.0);
  auto same = scene.ragged;
  move_outlines_to_edges(scene.picture, same, 0);
  EXPECT_EQ(same.elements(), scene.ragged.elements());
  Image<float> slanted(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x) slanted.at(x, y) = 0.5F + 0.001F * static_cast<float>(x + y);
  same = slanted;
  move_outlines_to_edges(scene.picture, same, kReach);
  EXPECT_EQ(same.elements(), slanted.elements()) << "a surface in perspective has no outline";
}

}  // namespace
}  // namespace kasumi
