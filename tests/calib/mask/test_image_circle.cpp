#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/result.hpp"
#include "base/units.hpp"
#include "calib/mask/fixed_circle.hpp"
#include "calib/mask/image_circle.hpp"
#include "tests/alpnach.hpp"
#include "tests/csv.hpp"
#include "tests/must.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
const fs::path kData(shared_data_folder());
constexpr double kNone = kLeastCircleConfidence;

// A sky with a bright sun inside a dark surround, anti-aliased at the rim, with noise everywhere.
struct Disc {
  int width = 400;
  int height = 400;
  glm::dvec2 centre{203.4, 196.7};
  double radius_px = 180.0;
  double sky = 90.0;
  double surround = 3.0;
  double noise = 2.0;
  // Transmitted fraction of the sky's light by azimuth and radius (1 at the rim).
  std::function<double(double, double)> open = [](double, double) { return 1.0; };
};

Image<Rgb8> drawn(const Disc& disc) {
  std::mt19937_64 random(7);
  const auto noise = [&] {  // nearly normal: a sum of twelve uniform numbers
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
    return disc.noise * sum;
  };
  Image<Rgb8> picture(disc.width, disc.height);
  for (int y = 0; y < disc.height; ++y)
    for (int x = 0; x < disc.width; ++x) {
      const glm::dvec2 offset = glm::dvec2{x, y} - disc.centre;
      const double r = glm::length(offset), azimuth = std::atan2(offset.y, offset.x);
      const double inside = std::clamp(disc.radius_px - r + 0.5, 0.0, 1.0);
      const double sun = 160.0 * std::exp(-glm::dot(offset - 50.0, offset - 50.0) / 800.0);
      const double light = (disc.sky + sun) * disc.open(azimuth, r / disc.radius_px);
      Rgb8& pixel = picture.at(x, y);
      for (int c = 0; c < 3; ++c) {
        const double value = disc.surround + inside * light * (0.7 + 0.15 * c) + noise();
        pixel[c] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
      }
    }
  return picture;
}

void expect_found(const Disc& disc, const char* what, double least_confidence = 0.5) {
  const auto found = find_image_circle(drawn(disc));
  ASSERT_TRUE(found) << what;
  EXPECT_NEAR(found->circle.radius_px, disc.radius_px, 0.01 * disc.radius_px) << what;
  EXPECT_LE(glm::distance(found->circle.centre, disc.centre), 0.01 * disc.radius_px) << what;
  EXPECT_LT(found->circle.sigma_px, 0.02 * disc.radius_px) << what;
  EXPECT_GT(found->confidence, least_confidence) << what;
  EXPECT_EQ(found->pixel_aspect, 1.0) << what;
}

TEST(ImageCircle, ADiscOnADarkSurroundIsFoundWithinOnePercent) {
  expect_found({}, "as it is");
  Disc noisy;
  noisy.noise = 6.0;
  noisy.surround = 12.0;
  expect_found(noisy, "noisy");
  Disc clean;
  clean.noise = 0.0;
  clean.surround = 0.0;
  clean.sky = 8.0;
  expect_found(clean, "underexposed");
  Disc small;
  small.radius_px = 60.0;
  small.centre = {120.2, 280.9};
  expect_found(small, "small and off-centre");
}

TEST(ImageCircle, TreesAndBuildingsOnTheHorizonDoNotShrinkIt) {
  Disc disc;
  disc.open = [](double azimuth, double r) {
    const double trees = 0.85 + 0.12 * std::sin(7.0 * azimuth) * std::sin(23.0 * azimuth + 1.0);
    const bool building = azimuth > 0.4 && azimuth < 1.1 && r > 0.6;
    return building || (azimuth < 0.0 && azimuth > -2.2 && r > trees) ? 0.0 : 1.0;
  };
  expect_found(disc, "buildings and trees", kNone);
}

TEST(ImageCircle, ARimHalfInDarknessIsEnough) {
  Disc disc;
  disc.open = [](double azimuth, double r) { return r > 0.8 && azimuth > -0.9 && azimuth < 2.3 ? 0.0 : 1.0; };
  expect_found(disc, "half dark", kNone);
}

TEST(ImageCircle, ACircleCutByTheImageBorderIsFound) {
  Disc disc;
  disc.width = 500;
  disc.height = 320;
  disc.centre = {247.8, 158.2};
  disc.radius_px = 190.0;
  expect_found(disc, "cut above and below");
}

TEST(ImageCircle, ALensFlareOutsideTheCircleIsNotMistakenForIt) {
  auto picture = drawn({});
  for (int y = 10; y < 30; ++y)
    for (int x = 340; x < 380; ++x) picture.at(x, y) = Rgb8{200, 200, 180};
  const auto found = must(find_image_circle(picture));
  EXPECT_NEAR(found->circle.radius_px, 180.0, 1.8);
}

TEST(ImageCircle, ARingOfStrayLightOutsideTheCircleIsNotFollowed) {
  auto picture = drawn({});
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const double away = glm::distance(glm::dvec2{x, y}, Disc{}.centre) - 193.0;
      const auto light = static_cast<std::uint8_t>(std::lround(14.0 * std::exp(-away * away / 4.0)));
      if (away > -8.0) picture.at(x, y) += Rgb8{light, light, light};
    }
  const auto found = must(find_image_circle(picture));
  EXPECT_NEAR(found->circle.radius_px, 180.0, 1.8);
}

TEST(ImageCircle, SurroundsOfAnyColourAreTold) {
  for (const Rgb8 surround : {Rgb8{255, 255, 255}, Rgb8{180, 180, 180}, Rgb8{30, 60, 140}, Rgb8{200, 60, 20}}) {
    auto picture = drawn({});
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x)
        if (glm::distance(glm::dvec2{x, y}, Disc{}.centre) > 180.0) picture.at(x, y) = surround;
    const auto found = must(find_image_circle(picture));
    EXPECT_NEAR(found->circle.radius_px, 180.0, 1.8) << int{surround.r};
    EXPECT_GT(found->confidence, 0.5) << int{surround.r};
  }
}

TEST(ImageCircle, ACircleCutOnAllSidesIsFoundByItsCorners) {
  Disc disc;
  disc.width = 480;
  disc.height = 360;
  disc.centre = {238.0, 181.0};
  disc.radius_px = 255.0;
  expect_found(disc, "only corners");
}

TEST(ImageCircle, HorizonAndEdgeAreBothToldWhereALandRingLiesBetween) {
  Disc disc;
  disc.open = [](double, double r) { return r > 0.92 ? 0.3 : 1.0; };
  const auto found = must(find_image_circle(drawn(disc)));
  EXPECT_NEAR(found->circle.radius_px, 180.0, 1.8);
  ASSERT_TRUE(found->horizon);
  EXPECT_NEAR(found->horizon->radius_px, 0.92 * 180.0, 1.8);
}

TEST(ImageCircle, PixelsThatAreNotSquareMakeAnEllipse) {
  const auto round = drawn({});
  Image<Rgb8> squeezed(round.width() * 15 / 16, round.height());  // 480 columns in 450
  for (int y = 0; y < squeezed.height(); ++y)
    for (int x = 0; x < squeezed.width(); ++x) squeezed.at(x, y) = round.at((x * 16 + 8) / 15, y);
  const auto found = must(find_image_circle(squeezed));
  EXPECT_NEAR(found->pixel_aspect, 16.0 / 15.0, 0.01);
  EXPECT_NEAR(found->circle.radius_px, 180.0, 2.0);
  EXPECT_LE(glm::distance(found->circle.centre, Disc{}.centre), 2.0) << "in square pixels";
}

TEST(ImageCircle, ALargePicturesCircleIsFoundWithinOnePercent) {
  Disc disc;
  disc.width = 2000;
  disc.height = 1600;
  disc.centre = {1010.6, 795.1};
  disc.radius_px = 760.0;
  expect_found(disc, "large");
}

double confidence_in(const Image<Rgb8>& picture) {
  const auto found = find_image_circle(picture);
  return found ? found->confidence : 0.0;
}

TEST(ImageCircle, ThereIsNoneInPicturesWithoutOne) {
  EXPECT_FALSE(find_image_circle({}));
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(4, 4)));
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(300, 200))) << "black";
  EXPECT_FALSE(find_image_circle(Image<Rgb8>(300, 200, Rgb8{120, 140, 160}))) << "grey";

  Image<Rgb8> rectangle(300, 300), landscape(300, 200), gradient(300, 200);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) {
      if (x > 60 && x < 240 && y > 70 && y < 235) rectangle.at(x, y) = Rgb8{150, 150, 150};
      if (y >= 200) continue;
      const double hills = 110.0 + 20.0 * std::sin(x / 30.0);
      landscape.at(x, y) = y < hills ? Rgb8{120, 150, 200} : Rgb8{5, 6, 4};
      gradient.at(x, y) = Rgb8(glm::u8vec3(static_cast<std::uint8_t>(x * 255 / 300)));
    }
  EXPECT_LT(confidence_in(rectangle), kNone) << "a rectangle";
  EXPECT_LT(confidence_in(landscape), kNone) << "a landscape";
  EXPECT_LT(confidence_in(gradient), kNone) << "a gradient";

  Disc dark;  // noise only
  dark.sky = 0.0;
  dark.open = [](double, double) { return 0.0; };
  EXPECT_LT(confidence_in(drawn(dark)), kNone) << "noise";
}

TEST(ImageCircle, ARealFisheyesCircleIsFoundWithinThreePixels) {
  if (!alpnach::is_there()) GTEST_SKIP() << "no sky pictures at " << alpnach::file(0);
  int found = 0;
  for (int exposure = 0; exposure < alpnach::kExposures; ++exposure) {
    const auto circle = find_image_circle(read_rgb(alpnach::file(exposure)));
    if (!circle || circle->confidence < 0.9) continue;
    ++found;
    EXPECT_NEAR(circle->circle.centre.x, 149.6, 3.0) << exposure;
    EXPECT_NEAR(circle->circle.centre.y, 140.7, 3.0) << exposure;
    EXPECT_NEAR(circle->circle.radius_px, 133.0, 3.0) << exposure;
  }
  EXPECT_GE(found, 3) << "of the brighter ones";
}

TEST(ImageCircle, ThereIsNoneInPhotographs) {
  const auto folder = kData / "haze";
  if (!fs::exists(folder)) GTEST_SKIP() << "no photographs at " << folder;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension != ".png" && extension != ".jpg") continue;
    EXPECT_LT(confidence_in(read_rgb(entry.path())), kNone) << entry.path();
  }
}

// The pictures of other people's cameras and what was measured in them by hand.
struct LabelledPicture {
  std::string file, camera, kind;
  std::vector<ImageCircle> circles;  // either is right; empty: no image circle
  double tolerance = 0.02;           // of the radius
};
std::vector<LabelledPicture> labelled_pictures(const fs::path& folder) {
  std::vector<LabelledPicture> pictures;
  for (CsvRow& row : read_csv(folder / "labels.csv")) {
    LabelledPicture picture{row["file"], row["camera"], row["kind"], {}, 0.02};
    if (!fs::exists(folder / picture.file)) continue;
    if (row["circle"] == "yes") {
      picture.tolerance = 0.01 * std::stod(row["tol"]);
      for (const char* other : {"", "2"})
        if (const auto r = row[std::string("r") + other]; !r.empty())
          picture.circles.push_back(
              {{std::stod(row[std::string("cx") + other]), std::stod(row[std::string("cy") + other])}, std::stod(r)});
    }
    pictures.push_back(picture);
  }
  return pictures;
}
bool near(const ImageCircle& circle, const LabelledPicture& picture) {
  return std::ranges::any_of(picture.circles, [&](const ImageCircle& label) {
    return std::max(glm::distance(circle.centre, label.centre), std::abs(circle.radius_px - label.radius_px)) <=
           picture.tolerance * label.radius_px;
  });
}
// Cameras weigh the same, however many pictures they took.
double share_of(const std::map<std::string, std::pair<int, int>>& right_of) {
  double sum = 0.0;
  for (const auto& [camera, counts] : right_of) sum += static_cast<double>(counts.first) / counts.second;
  return sum / static_cast<double>(std::max<std::size_t>(1, right_of.size()));
}

TEST(ImageCircle, StrangersCamerasAreUnderstood) {
  const auto folder = kData / "sky/real";
  if (!fs::exists(folder / "labels.csv")) GTEST_SKIP() << "no labelled pictures at " << folder;
  std::map<std::string, std::pair<int, int>> alone, together;  // by camera: right, all
  std::vector<SizedCircle> all;
  const auto pictures = labelled_pictures(folder);
  double seconds = 0.0;
  for (const auto& picture : pictures) {
    const auto pixels = read_rgb(folder / picture.file);
    const auto before = std::clock();
    all.push_back({pixels.width(), pixels.height(), find_image_circle(pixels)});
    seconds += static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    const auto& found = all.back().found;
    if (picture.circles.empty()) {
      EXPECT_LT(found ? found->confidence : 0.0, kNone) << picture.file;
      continue;
    }
    EXPECT_GT(found ? found->confidence : 0.0, kNone) << picture.file << ": a sky picture would be refused";
    auto& counts = alone[picture.camera];
    ++counts.second;
    if (found && near(found->circle, picture)) ++counts.first;
  }
  const auto fixed = circles_of_fixed_cameras(all);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].circles.empty()) continue;
    auto& counts = together[pictures[i].camera];
    ++counts.second;
    if (fixed[i] && near(fixed[i]->circle, pictures[i])) ++counts.first;
  }
  std::printf("image circle: %.1f %% of %zu cameras alone, %.1f %% together, %.0f ms a picture\n",
              100.0 * share_of(alone), alone.size(), 100.0 * share_of(together),
              1000.0 * seconds / static_cast<double>(pictures.size()));
  EXPECT_GE(share_of(alone), 0.93);
  EXPECT_GE(share_of(together), 0.97);
}

}  // namespace
}  // namespace kasumi
