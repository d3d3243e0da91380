// How near the image circle is to the truth, over generated fisheye pictures, and how far its confidence can be
// believed. The weights of the evidence were fitted to development pictures.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/calib/mask/rim_pictures.hpp"
#include "tests/calib/mask/strange_rims.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

constexpr double kFound = 0.5;  // confidence from which a circle counts as found

double error_of(const ImageCircle& found, const ImageCircle& truth) {
  return std::max(glm::distance(found.centre, truth.centre), std::abs(found.radius_px - truth.radius_px)) /
         truth.radius_px;
}

struct Circles {
  int pictures = 0, without = 0, made_up = 0;
  std::vector<double> errors;  // of centre and radius, the larger, over the radius

  double share_within(double error) const {
    const auto near = std::ranges::count_if(errors, [&](double e) { return e <= error; });
    return static_cast<double>(near) / static_cast<double>(std::max<std::size_t>(1, errors.size()));
  }
  double error(double share) const {
    auto sorted = errors;
    std::ranges::sort(sorted);
    return sorted.empty() ? 0.0 : sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
};

Circles circles_of(test::RimSet set) {
  std::vector<std::uint64_t> quarter(30), whole(150);
  for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = i;
  std::copy_n(whole.begin(), quarter.size(), quarter.begin());
  Circles circles;
  for (const std::uint64_t seed : figure_cases("fisheye pictures and as many without a circle", quarter, whole)) {
    const auto picture = test::draw_rim(set, seed);
    ++circles.pictures;
    if (const auto found = find_image_circle(picture.pixels); found && found->confidence >= kFound)
      circles.errors.push_back(error_of(found->circle, *picture.circle));
    ++circles.without;
    const auto made_up = find_image_circle(test::draw_without_rim(set, seed).pixels);
    if (made_up && made_up->confidence >= kFound) ++circles.made_up;
  }
  return circles;
}

void check(const char* set, const Circles& circles, const char* before) {
  std::printf(
      "%s: circle found in %zu of %d, median %.2f %% of the radius, 90%% %.2f, worst %.2f, within 1 %%: %.0f %%; "
      "of %d pictures without one found in %d\n    before: %s\n",
      set, circles.errors.size(), circles.pictures, 100.0 * circles.error(0.5), 100.0 * circles.error(0.9),
      100.0 * circles.error(1.0), 100.0 * circles.share_within(0.01), circles.without, circles.made_up, before);
  figure_row("found-generated", {fmt::format("image circle, {}: found; of these within 1 % of its radius", set),
                                 fmt::format("{} of {}; {:.0f} %", circles.errors.size(), circles.pictures,
                                             100.0 * circles.share_within(0.01)),
                                 "; all", "`test_air_truth_image_circle`"});
  EXPECT_GE(circles.share_within(0.02), 0.70);
  EXPECT_GE(circles.share_within(0.01), 0.45);
  EXPECT_GE(static_cast<int>(circles.errors.size()), circles.pictures / 2);
  EXPECT_LE(circles.made_up, 0.02 * circles.without);
}

TEST(AirTruthImageCircle, IsNearOrNotFoundInPicturesItWasMadeWith) {
  check("development", circles_of(test::RimSet::development),
        "31 of 40, median 1.58 %, 90 % 9.6, within 1 %: 35 %; of 40 without 3");
}

TEST(AirTruthImageCircle, IsNearOrNotFoundInOthers) {
  check("held out", circles_of(test::RimSet::held_out),
        "26 of 40, median 1.61 %, 90 % 13.6, within 1 %: 42 %; of 40 without 4");
}

// Surrounds of any colour, rings, flare, writing, walls and crops as strangers publish them.
struct Strange {
  int pictures = 0, near = 0, believed = 0, believed_wrong = 0, shapes_made_up = 0;
};
Strange strange_of(test::RimSet set) {
  std::vector<std::uint64_t> quarter(40), whole(200);
  for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = 1000 + i;
  std::copy_n(whole.begin(), quarter.size(), quarter.begin());
  Strange strange;
  for (const std::uint64_t seed : figure_cases("fisheye pictures of strangers, drawn", quarter, whole)) {
    const auto drawn = test::draw_strange_rim(set, seed);
    const auto found = find_image_circle(drawn.picture.pixels);
    ++strange.pictures;
    if (!found) continue;
    double error = error_of(found->circle, *drawn.picture.circle);
    if (drawn.horizon) error = std::min(error, error_of(found->circle, *drawn.horizon));
    const bool near = error <= 0.02;
    strange.near += near ? 1 : 0;
    if (found->confidence >= 0.9) {
      ++strange.believed;
      strange.believed_wrong += near ? 0 : 1;
    }
    strange.shapes_made_up += drawn.pixel_aspect == 1.0 && found->pixel_aspect != 1.0 ? 1 : 0;
  }
  return strange;
}

TEST(AirTruthImageCircle, IsNearInPicturesOfStrangersAndKnowsWhenItIsNot) {
  const Strange strange = strange_of(test::RimSet::held_out);
  std::printf("strangers: %d of %d within 2 %%; of %d believed at 0.9 %d wrong; %d made ellipses\n", strange.near,
              strange.pictures, strange.believed, strange.believed_wrong, strange.shapes_made_up);
  EXPECT_GE(strange.near, 0.75 * strange.pictures);
  EXPECT_GE(strange.believed, 0.6 * strange.pictures);
  EXPECT_LE(strange.believed_wrong, 0.1 * strange.believed);
  EXPECT_LE(strange.shapes_made_up, 0.01 * strange.pictures);
}

}  // namespace
}  // namespace kasumi
