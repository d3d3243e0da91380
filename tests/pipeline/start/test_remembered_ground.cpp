// What was learnt of the ground, kept over a restart.
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "pipeline/start/remembered_ground.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

class RememberedGround : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    appearance_.light.around = light_around_of([](const Direction&) { return glm::dvec3{0.1}; });
    appearance_.light.sun_irradiance = glm::dvec3{1.0};
    appearance_.light.sun_direction = {0.0, -0.6, 0.8};
    for (auto* grid : {&appearance_.horizon, &measured_}) {
      *grid = {.first_px = {-0.5, -0.5}, .last_px = {319.5, 179.5}};
      grid->light.fill(glm::dvec3{0.5});
    }
    appearance_.aerial_perspective = false;
  }

  // Level ground 39 m below the camera, 2 km away.
  std::shared_ptr<GroundWatch> watch(double north_m = 2000.0) const {
    Model model;
    model.materials = {{.name = "ground"}};
    ModelPart ground;
    for (const glm::vec3& at : {glm::vec3{-60, 0, 60}, {60, 0, 60}, {60, 0, -60}, {-60, 0, -60}})
      ground.vertices.push_back({.position = at, .normal = {0, 1, 0}});
    ground.indices = {0, 1, 2, 0, 2, 3};
    model.ground = {ground};
    return std::make_shared<GroundWatch>(camera_, model, Placement{.north_m = north_m, .up_m = -39.0});
  }
  void see(GroundWatch& watch, int minutes) const {
    const Image<Rgb8> picture(320, 180, Rgb8(90));
    FrameMetadata metadata;
    metadata.captured_at = Instant{std::chrono::minutes(minutes)};
    watch.see(view_of(picture), metadata, appearance_, measured_);
  }
  std::filesystem::file_time_type written() const { return std::filesystem::last_write_time(folder_ / "ground.bin"); }

  std::filesystem::path folder_ = test_folder("remembered-ground");
  Camera camera_ = fixtures::scene_camera({.width = 320, .height = 180, .heading_deg = 0.0, .pitch_deg = 0.0}).camera;
  ObjectAppearance appearance_;
  AirlightGrid measured_;
  ManualClock clock_{Utc{1'800'000'000s}};
};

TEST_F(RememberedGround, IsWrittenByTheHourAndOnlyWhereSomethingWasLearnt) {
  GroundKeeper keeper(clock_);
  const auto ground = watch();
  ASSERT_GT(ground->places(), 20u);
  keeper.recall(ground, folder_);
  see(*ground, 0);
  keeper.keep(folder_);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "ground.bin")) << "flash memory wears";
  clock_.advance(61min);
  keeper.keep(folder_);
  ASSERT_TRUE(std::filesystem::exists(folder_ / "ground.bin"));
  const auto first = written();
  clock_.advance(61min);
  keeper.keep(folder_);
  EXPECT_EQ(written(), first) << "nothing was learnt";
  see(*ground, 120);
  keeper.keep(folder_);
  EXPECT_NE(written(), first);

  const auto again = watch();
  keeper.recall(again, folder_);
  see(*again, 0);
  const auto kept = ground->learnt(), resumed = again->learnt();
  const auto fresh = watch();
  see(*fresh, 0);
  EXPECT_NE(kept.shares, fresh->learnt().shares);
  EXPECT_NE(resumed.shares, fresh->learnt().shares) << "it begins anew";
  ASSERT_EQ(kept.shares.size(), resumed.shares.size());
  EXPECT_EQ(kept.ground, resumed.ground);
}

TEST_F(RememberedGround, OfAnotherPlaceOrDamagedIsRefused) {
  const auto ground = watch();
  see(*ground, 0);
  const auto learnt = ground->learnt();
  EXPECT_TRUE(watch()->resume(learnt, 0.0));
  EXPECT_FALSE(watch(2050.0)->resume(learnt, 0.0));
  EXPECT_FALSE(ground->resume(learnt, 0.0)) << "it has begun";
  ASSERT_TRUE(save({clock_.utc(), learnt.ground, learnt.shares}, folder_));
  const auto loaded = load_ground_state(folder_);
  ASSERT_TRUE(loaded && *loaded);
  EXPECT_EQ((*loaded)->shares, learnt.shares);
  EXPECT_EQ((*loaded)->utc, clock_.utc());
  auto bytes = read_file(folder_ / "ground.bin").value();
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file(folder_ / "ground.bin", bytes));
  EXPECT_EQ(load_ground_state(folder_).error().kind, FaultKind::bad_input);
  const auto fresh = watch();
  GroundKeeper(clock_).recall(fresh, folder_);  // warns
  see(*fresh, 0);
  EXPECT_EQ(fresh->learnt().shares, learnt.shares) << "as if nothing had been kept";
}

}  // namespace
}  // namespace kasumi
