// Masks against the true masks of generated pictures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "calib/mask/scene_mask.hpp"
#include "calib/mask/sky_mask.hpp"
#include "calib/mask/sway_mask.hpp"
#include "fixtures/in_front/leaves.hpp"
#include "fixtures/landscape/fisheye_view.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Intersection over union of two grey masks.
double overlap(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b, bool inverted) {
  double both = 0.0, either = 0.0;
  for (std::size_t i = 0; i < a.elements().size(); ++i) {
    const int x = inverted ? 255 - a.elements()[i] : a.elements()[i],
              y = inverted ? 255 - b.elements()[i] : b.elements()[i];
    both += std::min(x, y);
    either += std::max(x, y);
  }
  return both / either;
}

TEST(SkyMask, ObstructionsAreFoundThroughCloudsSunAndHaze) {
  std::printf("seed  overlap of the sky, of what is hidden; of what stands taken for sky\n");
  for (const std::uint64_t seed : {2u, 11u}) {
    fixtures::FisheyeSpec options;
    options.size = 240;
    const Camera camera = fixtures::sky_camera(options).camera;
    std::vector<Image<Rgb8>> pictures;
    for (int i = 0; i < 9; ++i) {
      fixtures::Weather weather;
      weather.turbidity = 2.5 + 0.3 * i;
      weather.sun = direction_from(from_degrees(40.0 + 4.5 * i), from_degrees(170.0 + 10.0 * i));
      weather.cloud_cover = 0.4;
      weather.cloud_seed = seed;
      weather.time_s = 1200.0 * i;
      fixtures::FisheyeScenery view_options;
      view_options.seed = seed;
      const auto view = fixtures::look_at_sky(fixtures::Illumination(weather), camera, view_options);
      auto exposure = fixtures::automatic_exposure(view.light, 0.92, 0.72);
      exposure.noise = true;
      exposure.seed = seed + static_cast<std::uint64_t>(i);
      pictures.push_back(fixtures::expose(view.light, camera, exposure));
    }
    const auto found = must(find_sky_mask(pictures, camera, 0.0));
    // The true sky lies above the skyline's formula.
    Image<std::uint8_t> truth(camera.width, camera.height, 0);
    int standing = 0, missed = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const auto direction = camera.direction_at({x, y});
        if (!direction) continue;
        const double elevation = 0.5 * kPi - zenith_angle(*direction).value;
        if (elevation > fixtures::skyline_elevation(seed, azimuth_angle(*direction)).value) {
          truth.at(x, y) = 255;
          continue;
        }
        ++standing;
        if (found->mask.at(x, y) != 0) ++missed;
      }
    const double sky = overlap(truth, found->mask, false), hidden = overlap(truth, found->mask, true);
    const double share = static_cast<double>(missed) / standing;
    std::printf("%4d  %.4f %.4f  %.4f\n", static_cast<int>(seed), sky, hidden, share);
    EXPECT_GE(sky, 0.98);
    EXPECT_GE(hidden, 0.98);
    EXPECT_LE(share, 0.01);
  }
}

TEST(SkyMask, NightPicturesAreRefused) {
  const Camera camera = fixtures::sky_camera({.size = 64}).camera;
  const std::vector<Image<Rgb8>> night(3, Image<Rgb8>(64, 64, Rgb8(4)));
  EXPECT_THAT(find_sky_mask(night, camera, 2.0).error().message, HasSubstr("all of the night"));
}

struct Scene {
  Image<Rgb8> picture;
  Image<std::uint8_t> free;  // truth
};

// Trees on a knoll 3.5 km away in front of ridges in haze, hiding parts of a building 6 km away.
Scene scene_of(std::uint64_t seed) {
  const auto scene = fixtures::scene_camera({.width = 400, .height = 225});
  const auto geometry =
      fixtures::look_at_terrain(fixtures::Terrain(seed), scene.camera, from_degrees(scene.options.heading_deg));
  fixtures::Weather weather;
  weather.turbidity = 2.4;
  weather.sun = direction_from(from_degrees(50.0), from_degrees(130.0));
  weather.altitude_m = 980.0;
  const auto light = fixtures::look_at_scene(fixtures::Illumination(weather), scene.camera, geometry);
  auto exposure = fixtures::automatic_exposure(light, 0.97, 0.58);
  exposure.noise = true;
  exposure.seed = seed;
  return {fixtures::expose(light, scene.camera, exposure), fixtures::foreground_mask(geometry, 6000.0)};
}

// Strokes as a user draws them: short lines along both sides of the edge, 6 to 25 pixels away.
void draw_strokes(const Image<std::uint8_t>& free, Stroke kind, int count, std::mt19937_64& random,
                  Image<Stroke>& strokes) {
  cv::Mat inside(free.height(), free.width(), CV_8UC1), distance;
  for (int y = 0; y < free.height(); ++y)
    for (int x = 0; x < free.width(); ++x)
      inside.at<std::uint8_t>(y, x) = (free.at(x, y) > 250) == (kind == Stroke::free) ? 255 : 0;
  cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int drawn = 0, tries = 0; drawn < count && tries < 10000; ++tries) {
    double x = uniform() * (free.width() - 1), y = uniform() * (free.height() - 1);
    const float away = distance.at<float>(static_cast<int>(y), static_cast<int>(x));
    if (away < 6.0F || away > 25.0F) continue;
    ++drawn;
    const double turn = 2.0 * kPi * uniform();
    for (int step = 0; step < 60; ++step, x += std::cos(turn), y += 0.5 * std::sin(turn)) {
      if (x < 1 || y < 1 || x > free.width() - 2 || y > free.height() - 2) break;
      if (distance.at<float>(static_cast<int>(y), static_cast<int>(x)) < 4.0F) break;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) strokes.at(static_cast<int>(x) + dx, static_cast<int>(y) + dy) = kind;
    }
  }
}

// Whether all pixels next to it are like it: of leaves and what is seen between them no stroke can tell single pixels.
bool is_inside(const Image<std::uint8_t>& mask, int x, int y) {
  for (int v = std::max(0, y - 1); v <= std::min(mask.height() - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(mask.width() - 1, x + 1); ++u)
      if (mask.at(u, v) != mask.at(x, y)) return false;
  return true;
}

TEST(SceneMask, AFewStrokesCutTreesFromTheRidgesBehind) {
  std::printf("seed  overlap of what is hidden, of what is free\n");
  for (const std::uint64_t seed : {2u, 7u}) {
    const auto scene = scene_of(seed);
    Image<Stroke> strokes(scene.picture.width(), scene.picture.height(), Stroke::none);
    std::mt19937_64 random(seed);
    draw_strokes(scene.free, Stroke::hidden, 8, random, strokes);
    draw_strokes(scene.free, Stroke::free, 8, random, strokes);
    auto found = must(find_scene_mask(scene.picture, strokes, {}));
    for (int y = 0; y < scene.free.height(); ++y)
      for (int x = 0; x < scene.free.width(); ++x)
        if (!is_inside(scene.free, x, y)) found->mask.at(x, y) = scene.free.at(x, y);
    const double hidden = overlap(scene.free, found->mask, true), free = overlap(scene.free, found->mask, false);
    std::printf("%4d  %.4f %.4f\n", static_cast<int>(seed), hidden, free);
    EXPECT_GE(hidden, 0.98);
    EXPECT_GE(free, 0.98);
  }
}

TEST(SceneMask, NothingIsHiddenOutsideTheBox) {
  const auto scene = scene_of(2);
  Image<Stroke> strokes(scene.picture.width(), scene.picture.height(), Stroke::none);
  std::mt19937_64 random(1);
  draw_strokes(scene.free, Stroke::hidden, 12, random, strokes);
  draw_strokes(scene.free, Stroke::free, 12, random, strokes);
  const auto found =
      must(find_scene_mask(scene.picture, strokes, {.box = glm::ivec4(100, 60, 200, 150), .soft_px = 2.0}));
  int hidden_inside = 0;
  for (int y = 0; y < 225; ++y)
    for (int x = 0; x < 400; ++x) {
      const bool inside = x >= 100 && x < 300 && y >= 60 && y < 210;
      if (inside)
        hidden_inside += found->mask.at(x, y) == 0 ? 1 : 0;
      else
        ASSERT_EQ(found->mask.at(x, y), 255);
    }
  EXPECT_GT(hidden_inside, 100);
  EXPECT_THAT(find_scene_mask(scene.picture, strokes, {.box = glm::ivec4(0, 0, 20, 20), .soft_px = 2.0}),
              FailsWith(HasSubstr("what stands in front")));
}

constexpr int kCloudyPictures = 24;
// A minute and a half under moving clouds and their shadows, with noise and the camera's own exposure.
std::vector<Image<Rgb8>> draw_cloudy_minutes() {
  const auto scene = fixtures::scene_camera({.width = 320, .height = 180});
  const auto geometry =
      fixtures::look_at_terrain(fixtures::Terrain(2), scene.camera, from_degrees(scene.options.heading_deg));
  std::vector<Image<Rgb8>> pictures;
  for (int i = 0; i < kCloudyPictures; ++i) {
    fixtures::Weather weather;
    weather.turbidity = 2.4;
    weather.sun = direction_from(from_degrees(50.0), from_degrees(130.0 + 0.02 * i));
    weather.altitude_m = 980.0;
    weather.cloud_cover = 0.45;
    weather.cloud_seed = 3;
    weather.time_s = 4.0 * i;
    const auto light = fixtures::look_at_scene(fixtures::Illumination(weather), scene.camera, geometry);
    auto exposure = fixtures::automatic_exposure(light, 0.97, 0.58);
    exposure.noise = true;
    exposure.seed = static_cast<std::uint64_t>(i);
    pictures.push_back(fixtures::expose(light, scene.camera, exposure));
  }
  return pictures;
}
const std::vector<Image<Rgb8>>& cloudy_minutes() {
  static const auto pictures = draw_cloudy_minutes();
  return pictures;
}

TEST(SwayMask, CloudsAndWhoWalksByProposeNothing) {
  auto pictures = cloudy_minutes();
  EXPECT_TRUE(find_sway_mask(pictures, Response::srgb(), {}).mask.empty());
  // Somebody crosses the picture once, 12 pixels a step.
  for (int i = 0; i < kCloudyPictures; ++i)
    for (int y = 110; y < 160; ++y)
      for (int x = 12 * i; x < 12 * i + 16; ++x) pictures[static_cast<std::size_t>(i)].at(x, y) = {70, 40, 35};
  EXPECT_TRUE(find_sway_mask(pictures, Response::srgb(), {}).mask.empty());
}

TEST(SwayMask, ABoughThatSwaysIsFoundUnderMovingClouds) {
  auto pictures = cloudy_minutes();
  const fixtures::Bough bough({.width = 320,
                               .height = 180,
                               .root_px = {-40, 50},
                               .tip_px = {200, 105},
                               .spread_px = 80,
                               .leaves = 1300,
                               .leaf_px = 9,
                               .sway_px = 5,
                               .seed = 4});
  std::vector<double> seconds;
  for (int i = 0; i < kCloudyPictures; ++i) {
    seconds.push_back(4.03 * i);
    pictures[static_cast<std::size_t>(i)] =
        fixtures::put_before(pictures[static_cast<std::size_t>(i)], bough.at(seconds.back()));
  }
  const auto truth = fixtures::mask_of(bough, seconds);
  const auto found = find_sway_mask(pictures, Response::srgb(), {});
  ASSERT_FALSE(found.mask.empty());
  std::filesystem::create_directories(test_output_folder());
  for (const auto& [name, mask] : {std::pair{"sway.png", &found.mask}, {"sway-truth.png", &truth}}) {
    cv::Mat1b grey(180, 320);
    std::ranges::copy(mask->elements(), grey.begin());
    ASSERT_TRUE(cv::imwrite((test_output_folder() / name).string(), grey));
  }
  // Where leaves never were, where they always were, and how far the share is off between.
  double off = 0.0;
  int free = 0, taken = 0, covered = 0, opened = 0, band = 0;
  for (std::size_t i = 0; i < truth.elements().size(); ++i) {
    const int is = found.mask.elements()[i], should = truth.elements()[i];
    if (should == 255) ++free, taken += is < 250;
    if (should == 0) ++covered, opened += is > 5;
    if (should > 0 && should < 255) ++band, off += std::abs(is - should) / 255.0;
  }
  std::printf("free taken %.4f, covered opened %.4f, band's share off by %.3f\n", double(taken) / free,
              double(opened) / covered, off / band);
  EXPECT_LE(taken, free / 100);
  EXPECT_LE(opened, covered / 50);
  EXPECT_LE(off / band, 0.05);
}

TEST(Strokes, APaintedPictureAndAListOfLinesAreEquivalent) {
  const auto folder = test_output_folder() / "strokes";
  std::filesystem::create_directories(folder);
  cv::Mat painted(60, 80, CV_8UC3, cv::Scalar(128, 128, 128));
  cv::line(painted, {10, 10}, {40, 10}, cv::Scalar(0, 0, 255), 3);
  cv::line(painted, {10, 40}, {40, 50}, cv::Scalar(0, 255, 0), 3);
  ASSERT_TRUE(cv::imwrite((folder / "strokes.png").string(), painted));
  ASSERT_TRUE(write_text_file(folder / "strokes.toml",
                              "[[hidden]]\npoints = [10, 10, 40, 10]\nwidth_px = 3\n"
                              "[[free]]\npoints = [10, 40, 40, 50]\nwidth_px = 3\n"));
  const auto a = read_strokes(folder / "strokes.png", 80, 60).value(),
             b = read_strokes(folder / "strokes.toml", 80, 60).value();
  EXPECT_EQ(a.elements(), b.elements());
  EXPECT_EQ(a.at(20, 10), Stroke::hidden);
  EXPECT_EQ(a.at(25, 45), Stroke::free);

  ASSERT_TRUE(write_text_file(folder / "wrong.toml",
                              "[[hidden]]\npoints = [10, 10, 400, 10]\n[[free]]\npoints = [1, 2, 3]\ncolour = 1\n"));
  EXPECT_THAT(read_strokes(folder / "wrong.toml", 80, 60).error().message,
              testing::AllOf(HasSubstr("hidden[0].points"), HasSubstr("free[0].points"), HasSubstr("free[0].colour")));
  EXPECT_THAT(read_strokes(folder / "strokes.png", 81, 60).error().message, HasSubstr("80 x 60, expected 81 x 60"));
}

}  // namespace
}  // namespace kasumi
