// The scene camera's pose from landmarks, against cameras of known pose with noise of known size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/pose/scene_pose.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) + 0.5) * 0x1.0p-53;
  }
  double normal() { return std::sqrt(-2.0 * std::log(uniform(0.0, 1.0))) * std::cos(2.0 * kPi * uniform(0.0, 1.0)); }

 private:
  std::mt19937_64 engine_;
};

struct Rig {
  int width = 1920, height = 1080;
  LensDescription lens;
  glm::dmat3 to_world{1.0};
  ScenePrior prior() const {
    ScenePrior known;
    known.width = width;
    known.height = height;
    known.lens = lens;
    return known;
  }
};

// A camera of this focal length in pixels, looking nearly level.
Rig rig(double focal_px, Random& random) {
  Rig made;
  made.lens = {PinholeParameters{{focal_px, focal_px}, {961.0, 537.0}, {-0.08, 0.03, 0.0, 0.0, 0.0}}};
  made.to_world = camera_to_world(from_degrees(random.uniform(-180.0, 180.0)), from_degrees(random.uniform(-3.0, 6.0)),
                                  from_degrees(random.uniform(-4.0, 4.0)));
  return made;
}

// Anywhere in the picture, 1 to 12 km away, marked with noise.
LandmarkSight landmark(const Rig& rig, const std::string& name, Random& random, double sigma_px) {
  const glm::dvec2 pixel{random.uniform(40.0, rig.width - 40.0), random.uniform(40.0, rig.height - 40.0)};
  LandmarkSight sight;
  sight.name = name;
  sight.place_m = random.uniform(1e3, 12e3) * (rig.to_world * make_lens(rig.lens)->unproject(pixel).value());
  sight.pixel = pixel + sigma_px * glm::dvec2{random.normal(), random.normal()};
  sight.sigma_px = sigma_px;
  return sight;
}

std::vector<LandmarkSight> landmarks(const Rig& rig, int count, Random& random, double sigma_px) {
  std::vector<LandmarkSight> sights;
  for (int i = 0; i < count; ++i)
    sights.push_back(landmark(rig, std::string(1, static_cast<char>('A' + i)), random, sigma_px));
  return sights;
}

// The largest angle between true and estimated viewing direction over the picture's pixels.
double worst_direction_deg(const Rig& rig, const ScenePose& pose) {
  const auto truth = make_lens(rig.lens), found = make_lens(pose.lens);
  Radians worst{};
  for (const double x : {0.0, 0.5, 1.0})
    for (const double y : {0.0, 0.5, 1.0}) {
      const glm::dvec2 pixel{x * (rig.width - 1.0), y * (rig.height - 1.0)};
      worst = std::max(worst, angle_between(rig.to_world * truth->unproject(pixel).value(),
                                            pose.to_world * found->unproject(pixel).value()));
    }
  return to_degrees(worst);
}

double percentile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

TEST(ScenePose, SixLandmarksWithOneGrossErrorGiveThePose) {
  // 20 deg across: 1 px is .0105 deg. The wrong one is off by 12 px to a fifth of the picture.
  constexpr int kSeeds = 300;
  std::vector<double> axis, anywhere, expected;
  int named = 0, too_many = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    const auto camera = rig(5450.0, random);
    auto sights = landmarks(camera, 6, random, 1.0);
    const auto wrong = static_cast<std::size_t>(random.uniform(0.0, 6.0));
    const double off = std::exp(random.uniform(std::log(12.0), std::log(384.0))), way = random.uniform(0.0, 2.0 * kPi);
    sights[wrong].pixel += off * glm::dvec2{std::cos(way), std::sin(way)};
    const auto pose = must(pose_scene(sights, {}, camera.prior()));
    axis.push_back(to_degrees(angle_between(pose->to_world[2], camera.to_world[2])));
    anywhere.push_back(worst_direction_deg(camera, *pose));
    expected.push_back(to_degrees(pose->sigma.anywhere));
    if (!pose->used[wrong]) ++named;
    if (std::count(pose->used.begin(), pose->used.end(), false) > 1) ++too_many;
  }
  std::printf("optical axis: median %.4f, 95 %% %.4f, largest %.4f deg\n", percentile(axis, 0.5),
              percentile(axis, 0.95), percentile(axis, 1.0));
  std::printf("any pixel:    median %.4f, 95 %% %.4f, largest %.4f deg; sigma said, median %.4f\n",
              percentile(anywhere, 0.5), percentile(anywhere, 0.95), percentile(anywhere, 1.0),
              percentile(expected, 0.5));
  std::printf("the wrong one left out in %d of %d, more than it in %d\n", named, kSeeds, too_many);
  EXPECT_LE(percentile(axis, 0.95), 0.02);
  EXPECT_GE(named, kSeeds * 98 / 100);
  EXPECT_LE(too_many, kSeeds * 4 / 100);
}

TEST(ScenePose, TheReportedSigmaIsTheActualError) {
  // Errors over their sigmas are standard normal: mean square 1, here with 1 sqrt(2 / 200) = .1 of sampling error.
  constexpr int kSeeds = 200;
  double heading = 0.0, pitch = 0.0, scale = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Random random(1000 + seed);
    const auto camera = rig(2000.0, random);
    auto prior = camera.prior();
    const auto sights = landmarks(camera, 8, random, 0.7);
    prior.lens = moved(camera.lens, centre_of(camera.lens), 1.0 + 0.03 * random.normal());
    prior.scale_sigma = 0.03;
    const auto pose = must(pose_scene(sights, {}, prior));
    const glm::dvec3 error = glm::transpose(camera.to_world) * pose->to_world[2];
    heading += std::pow(error.x / pose->sigma.heading.value, 2) / kSeeds;
    pitch += std::pow(error.y / pose->sigma.pitch.value, 2) / kSeeds;
    const double found = focal_px_of(pose->lens) / focal_px_of(camera.lens) - 1.0;
    scale += std::pow(found / pose->sigma.scale, 2) / kSeeds;
  }
  // A misfit above 1 widens sigma but one below does not narrow it, hence a little less than 1.
  for (const double square : {heading, pitch, scale}) {
    EXPECT_GT(square, 0.55);
    EXPECT_LT(square, 1.3);
  }
}

TEST(ScenePose, APoorlyKnownFocalLengthIsFoundDespiteAWrongLandmark) {
  std::vector<double> focal_percent, axis;
  for (int seed = 1; seed <= 100; ++seed) {
    Random random(3000 + seed);
    const auto camera = rig(5450.0, random);
    auto prior = camera.prior();
    prior.lens = moved(camera.lens, centre_of(camera.lens), random.uniform(0.95, 1.05));
    prior.scale_sigma = 0.03;
    auto sights = landmarks(camera, 7, random, 1.0);
    sights[2].pixel += glm::dvec2{70.0, -40.0};
    const auto pose = must(pose_scene(sights, {}, prior));
    focal_percent.push_back(100.0 * std::abs(focal_px_of(pose->lens) / focal_px_of(camera.lens) - 1.0));
    axis.push_back(to_degrees(angle_between(pose->to_world[2], camera.to_world[2])));
  }
  // 1 px over landmarks 500 px from the centre: .09 % by the bound for six.
  EXPECT_LE(percentile(focal_percent, 0.95), 0.3);
  EXPECT_LE(percentile(axis, 0.95), 0.02);
}

TEST(ScenePose, TheHorizonLevelsACameraWhoseLandmarksAreTooCloseTogether) {
  Random random(7);
  const auto camera = rig(1500.0, random);
  const auto lens = make_lens(camera.lens);
  std::vector<LandmarkSight> sights;
  for (const char* name : {"left tower", "right tower"}) {
    LandmarkSight sight{name, {}, glm::dvec2{900.0 + 12.0 * static_cast<double>(sights.size()), 500.0}, 1.0, 0.0};
    sight.place_m = 5000.0 * (camera.to_world * lens->unproject(sight.pixel).value());
    sight.pixel += glm::dvec2{random.normal(), random.normal()};
    sights.push_back(sight);
  }
  const auto without = must(pose_scene(sights, {}, camera.prior()));
  ASSERT_FALSE(without->undetermined.empty());
  EXPECT_THAT(without->undetermined.front(), HasSubstr("roll"));

  // Seen from 200 m above the sea; Bowditch's table gives a dip of 1.76' sqrt(h / m) = 24.9' with usual refraction.
  const Radians dip = dip_of_horizon(200.0, 0.16);
  EXPECT_NEAR(60.0 * to_degrees(dip), 1.76 * std::sqrt(200.0), 0.15);
  std::vector<HorizonSight> horizon;
  const auto ahead = azimuth_angle(camera.to_world[2]);
  for (const double off : {-20.0, -8.0, 5.0, 18.0}) {
    const auto direction = direction_from(from_degrees(90.0) + dip, ahead + from_degrees(off));
    horizon.push_back(
        {lens->project(direction * camera.to_world).value() + glm::dvec2{0.0, random.normal()}, dip, 1.0});
  }
  const auto with = must(pose_scene(sights, horizon, camera.prior()));
  EXPECT_LE(to_degrees(with->sigma.roll), 0.1);
  EXPECT_LE(to_degrees(angle_between(with->to_world[0], camera.to_world[0])), 0.2);
  EXPECT_THAT(with->horizon_used, testing::Each(true));
}

TEST(ScenePose, ThreeSunSightingsAndTheHorizonGiveThePoseAndOneIsEnough) {
  // 20 deg across, 1 px of noise is .0105 deg. The sun crosses the upper part of the picture; the sea lies below.
  std::vector<double> three, one;
  for (int seed = 1; seed <= 100; ++seed) {
    Random random(5000 + seed);
    auto camera = rig(5450.0, random);
    const double heading = random.uniform(-180.0, 180.0);
    camera.to_world = camera_to_world(from_degrees(heading), from_degrees(random.uniform(1.0, 4.0)),
                                      from_degrees(random.uniform(-3.0, 3.0)));
    const auto lens = make_lens(camera.lens);
    const auto noise = [&] { return glm::dvec2{random.normal(), random.normal()}; };
    std::vector<LandmarkSight> sights;
    for (const double hour : {-0.4, 0.05, 0.4}) {
      const auto sun = direction_from(from_degrees(90.0 - 4.5 + 6.0 * hour), from_degrees(heading + 14.0 * hour));
      const auto pixel = must(lens->project(sun * camera.to_world));
      sights.push_back({"the sun", 1.5e11 * sun, *pixel + noise(), 1.0, 0.0});
    }
    const Radians dip = dip_of_horizon(500.0, 0.16);
    std::vector<HorizonSight> horizon;
    for (const double off : {-8.0, -3.0, 3.0, 8.0}) {
      const auto sea = direction_from(from_degrees(90.0) + dip, from_degrees(heading + off));
      horizon.push_back({lens->project(sea * camera.to_world).value() + noise(), dip, 1.0});
    }
    const auto pose = must(pose_scene(sights, horizon, camera.prior()));
    three.push_back(to_degrees(angle_between(pose->to_world[2], camera.to_world[2])));
    const auto from_one = must(pose_scene(std::span(sights).first(1), horizon, camera.prior()));
    one.push_back(to_degrees(angle_between(from_one->to_world[2], camera.to_world[2])));
  }
  std::printf("optical axis, three suns: median %.4f, 95 %% %.4f, largest %.4f deg; one: %.4f, %.4f, %.4f deg\n",
              percentile(three, 0.5), percentile(three, 0.95), percentile(three, 1.0), percentile(one, 0.5),
              percentile(one, 0.95), percentile(one, 1.0));
  EXPECT_LE(percentile(three, 0.95), 0.02);
  EXPECT_LE(percentile(one, 0.95), 0.04);
}

TEST(ScenePose, AWrongCameraPositionIsNoticedByNearLandmarks) {
  Random random(11);
  const auto camera = rig(1500.0, random);
  auto sights = landmarks(camera, 8, random, 0.5);
  // Four at 150 m, seen from 4 m beside the assumed site.
  const glm::dvec3 stands{3.0, -2.5, 0.5};
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (i % 2 == 0) sights[i].place_m *= 150.0 / glm::length(sights[i].place_m);
    sights[i].place_m += stands;
  }
  auto prior = camera.prior();
  prior.position_sigma_m = 3.0;
  const auto pose = must(pose_scene(sights, {}, prior));
  // Across the line of sight; a shift along it has little effect.
  EXPECT_LE(std::abs(glm::dot(pose->position_m - stands, camera.to_world[0])), 0.3);
  EXPECT_LE(std::abs(glm::dot(pose->position_m - stands, camera.to_world[1])), 0.3);
  EXPECT_LE(worst_direction_deg(camera, *pose), 0.05);
}

TEST(ScenePose, MissingRedundancyIsReportedAndNonsenseIsRefused) {
  Random random(5);
  const auto camera = rig(3000.0, random);
  auto sights = landmarks(camera, 2, random, 1.0);
  auto prior = camera.prior();
  prior.scale_sigma = 0.03;
  const auto two = must(pose_scene(sights, {}, prior));
  EXPECT_THAT(two->undetermined, testing::Contains(HasSubstr("too little else checks it")));

  EXPECT_FALSE(pose_scene(std::span(sights).first(1), {}, prior));
  auto nonsense = landmarks(camera, 6, random, 1.0);
  for (auto& sight : nonsense) sight.pixel = {random.uniform(0, 1919), random.uniform(0, 1079)};
  EXPECT_THAT(pose_scene(nonsense, {}, camera.prior()), FailsWith(HasSubstr("expected the right places")));
}

}  // namespace
}  // namespace kasumi
