// What was learnt of the ground, kept over a restart.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/units.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "pipeline/kiosk/start/remembered_ground.hpp"
#include "tests/pipeline/kiosk/appliance/journal.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

// Level ground 39 m below the camera, 2 km away; which camera, which ground.
struct View {
  double north_m = 2000.0, heading_deg = 0.0;
  int width = 320, height = 180;
  float colour = 0.3f, half_m = 60.0f;
};

class RememberedGround : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    appearance_.light.around = light_around_of([](const Direction&) { return glm::dvec3{kSky}; });
    appearance_.light.sun_irradiance = glm::dvec3{kSun};
    appearance_.light.sun_direction = {0.0, -0.6, 0.8};
    for (auto* grid : {&appearance_.horizon, &measured_}) {
      *grid = {.first_px = {-0.5, -0.5}, .last_px = {319.5, 179.5}};
      grid->light.fill(glm::dvec3{0.5});
    }
    appearance_.aerial_perspective = false;
  }

  static Camera camera(const View& view = {}) {
    return fixtures::scene_camera(
               {.width = view.width, .height = view.height, .heading_deg = view.heading_deg, .pitch_deg = 0.0})
        .camera;
  }
  static std::shared_ptr<GroundWatch> watch(const View& view = {}) {
    Model model;
    model.materials = {{.name = "ground", .base_colour = glm::vec4(glm::vec3(view.colour), 1.0f)}};
    ModelPart ground;
    const float half = view.half_m;
    for (const glm::vec3& at : {glm::vec3{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}})
      ground.vertices.push_back({.position = at, .normal = {0, 1, 0}});
    ground.indices = {0, 1, 2, 0, 2, 3};
    model.ground = {ground};
    return std::make_shared<GroundWatch>(camera(view), model, Placement{.north_m = view.north_m, .up_m = -39.0});
  }
  void see(GroundWatch& watch, int minutes) const { see(watch, minutes, Image<Rgb8>(320, 180, Rgb8(90))); }
  void see(GroundWatch& watch, int minutes, const Image<Rgb8>& picture) const {
    FrameMetadata metadata;
    metadata.captured_at = Instant{std::chrono::minutes(minutes)};
    watch.see(view_of(picture), metadata, appearance_, measured_);
  }
  // Under a sun that rises and sinks within ten hours; from `shaded` on (a column) it does not reach the ground.
  void see_hour(GroundWatch& watch, double hour, int shaded) {
    const double high = from_degrees(5.0 + 50.0 * std::sin(kPi * hour / 10.0)).value;
    appearance_.light.sun_direction = {0.0, -std::cos(high), std::sin(high)};
    const Response response = camera().response;
    const auto code_of = [&](double light) {
      return Rgb8(
          static_cast<std::uint8_t>(std::lround(255.0 * response.to_encoded(glm::dvec3{kReflectance * light}).g)));
    };
    const Rgb8 lit = code_of(kSun * std::sin(high) / kPi + kSky), shade = code_of(kSky);
    Image<Rgb8> picture(320, 180, lit);
    for (int y = 0; y < 180; ++y)
      for (int x = shaded; x < 320; ++x) picture.at(x, y) = shade;
    see(watch, static_cast<int>(std::lround(60.0 * hour)), picture);
  }
  // Of each point of the grid, the sun's share.
  static const std::vector<float>& sunlit(const GroundWatch& watch) { return watch.look().sunlight->share.elements(); }
  static double furthest(const std::vector<float>& a, const std::vector<float>& b) {
    double off = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) off = std::max(off, std::abs(double(a[i]) - double(b[i])));
    return off;
  }
  std::filesystem::path file() const { return folder_ / "ground.bin"; }
  std::filesystem::file_time_type written() const { return std::filesystem::last_write_time(file()); }

  // What a start with the folder's file says; it begins anew.
  std::string refusal(const View& view = {}) {
    const Journal journal;
    const auto fresh = watch(view), started = watch(view);
    GroundKeeper(clock_).recall(started, folder_);
    const Image<Rgb8> picture(view.width, view.height, Rgb8(90));
    for (const auto& ground : {fresh, started}) see(*ground, 0, picture);
    EXPECT_EQ(started->learnt().shares, fresh->learnt().shares) << "as if nothing had been kept";
    return journal.text();
  }

  static constexpr double kSun = 1.0, kSky = 0.1, kReflectance = 0.12;
  std::filesystem::path folder_ = test_folder("remembered-ground");
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

TEST_F(RememberedGround, ComesBackAsItWasSaved) {
  const auto ground = watch();
  see(*ground, 0);
  const auto learnt = ground->learnt();
  ASSERT_TRUE(save({clock_.utc(), learnt.ground, learnt.shares}, folder_));
  const auto loaded = load_ground_state(folder_);
  ASSERT_TRUE(loaded && *loaded);
  EXPECT_EQ((*loaded)->ground, learnt.ground);
  EXPECT_EQ((*loaded)->shares, learnt.shares);
  EXPECT_EQ((*loaded)->utc, clock_.utc());
  EXPECT_TRUE(watch()->resume(learnt, 0.0));
  EXPECT_FALSE(ground->resume(learnt, 0.0)) << "it has begun";
}

// A day of a sun that comes and goes, and from the seventh hour on a hill's shadow over half of the ground.
TEST_F(RememberedGround, TellsSunFromShadeAsBeforeTheRestart) {
  constexpr int kHalf = 160, kNone = 320;
  const auto before = watch();
  GroundKeeper keeper(clock_);
  keeper.recall(before, folder_);
  for (double hour = 1.0; hour < 8.0; hour += 1.0 / 12.0) see_hour(*before, hour, hour < 7.0 ? kNone : kHalf);
  clock_.advance(7h);
  keeper.keep(folder_);

  clock_.advance(10min);
  const auto after = watch(), forgetful = watch();
  GroundKeeper(clock_).recall(after, folder_);
  for (const auto& ground : {before, after, forgetful}) see_hour(*ground, 8.0 + 1.0 / 6.0, kHalf);
  const double off = furthest(sunlit(*after), sunlit(*before));
  const double forgotten = furthest(sunlit(*forgetful), sunlit(*before));
  fmt::print(
      "share of the sun's light: {:.4f} off at most after a restart, {:.2f} without the file; known {:.2f}, {:.2f}\n",
      off, forgotten, *after->look().known, *forgetful->look().known);
  EXPECT_LE(off, 0.004);  // a step of 255
  EXPECT_GE(forgotten, 0.3);
  EXPECT_EQ(after->look().known, before->look().known);
  const auto [shaded, lit] = std::ranges::minmax(sunlit(*after));
  EXPECT_LE(shaded, 0.05f);
  EXPECT_GE(lit, 0.95f);
}

// A week off leaves half of it; after two nothing of it counts.
TEST_F(RememberedGround, IsForgottenWhileItIsNotSeen) {
  const auto before = watch();
  for (double hour = 1.0; hour < 8.0; hour += 1.0 / 12.0) see_hour(*before, hour, 320);
  const auto learnt = before->learnt();
  const auto fresh = watch(), old = watch();
  EXPECT_TRUE(old->resume(learnt, 15.0 * 86400.0));
  for (const auto& ground : {fresh, old}) see_hour(*ground, 8.0, 160);
  EXPECT_LE(furthest(sunlit(*old), sunlit(*fresh)), 1e-4);
}

TEST_F(RememberedGround, OfAnotherGroundOrViewIsRefused) {
  const auto ground = watch();
  see(*ground, 0);
  const auto learnt = ground->learnt();
  ASSERT_TRUE(save({clock_.utc(), learnt.ground, learnt.shares}, folder_));
  const Journal journal;
  const auto same = watch();
  GroundKeeper(clock_).recall(same, folder_);
  see(*same, 0);
  EXPECT_EQ(journal.text(), "");
  EXPECT_NE(same->learnt().shares, learnt.shares) << "it has seen that picture twice";
  for (const View& other : {View{.north_m = 2050.0}, View{.heading_deg = 1.0}, View{.width = 640, .height = 360},
                            View{.colour = 0.2f}, View{.half_m = 50.0f}})
    EXPECT_THAT(refusal(other), testing::HasSubstr("ground.bin: of another ground or view; learning anew"))
        << other.north_m << " m, " << other.heading_deg << " deg, " << other.width << " px, " << other.colour << ", "
        << other.half_m << " m";
}

TEST_F(RememberedGround, DamagedIsRefused) {
  const auto ground = watch();
  see(*ground, 0);
  const auto learnt = ground->learnt();
  ASSERT_TRUE(save({clock_.utc(), learnt.ground, learnt.shares}, folder_));
  const auto whole = read_file(file()).value();
  const auto begins = std::ranges::find(whole, std::uint8_t{'\n'}) - whole.begin() + 1;
  const auto changed = [&](const auto& change) {
    auto bytes = whole;
    change(bytes);
    EXPECT_TRUE(write_file(file(), bytes));
  };
  const auto expect_damaged = [&](const char* how) {
    EXPECT_THAT(refusal(), testing::HasSubstr("ground.bin: damaged; learning anew")) << how;
  };
  changed([](auto& bytes) { bytes.resize(bytes.size() / 2); });
  EXPECT_EQ(load_ground_state(folder_).error().kind, FaultKind::bad_input);
  expect_damaged("the end is missing");
  changed([](auto& bytes) { bytes.push_back(0); });
  expect_damaged("more than was written");
  changed([](auto& bytes) { bytes.clear(); });
  expect_damaged("empty");
  changed([&](auto& bytes) { std::fill(bytes.begin() + begins, bytes.end(), std::uint8_t{0}); });
  expect_damaged("blocks of a disk that were never written");
  changed([](auto& bytes) { bytes[3] ^= 0x40; });
  expect_damaged("its kind");
  changed([](auto& bytes) { std::ranges::fill(bytes, std::uint8_t{'x'}); });
  expect_damaged("not a line");
}

// A slot that was rolled back finds what the newer program wrote.
TEST_F(RememberedGround, OfAnotherVersionIsRefused) {
  const std::string text = "kasumi-ground-2 2027-01-15T08:00:00Z 1-0 3\n...";
  ASSERT_TRUE(write_text_file(file(), text));
  EXPECT_THAT(refusal(), testing::HasSubstr("ground.bin: of another version of kasumi; learning anew"));
}

// Its light was explained by a sun that stood elsewhere.
TEST_F(RememberedGround, LearntWhileTheClockWasWrongIsRefused) {
  const auto ground = watch();
  see(*ground, 0);
  const auto learnt = ground->learnt();
  const auto saved_at = [&](Utc utc) {
    std::filesystem::remove(file());
    ASSERT_TRUE(save({utc, learnt.ground, learnt.shares}, folder_));
  };
  saved_at(clock_.utc() + 1h);
  EXPECT_THAT(refusal(), testing::HasSubstr("which is still to come; learning anew"));
  saved_at(clock_.utc() + 1min);  // as a clock is put right
  const Journal journal;
  const auto same = watch();
  GroundKeeper(clock_).recall(same, folder_);
  EXPECT_EQ(journal.text(), "");
}

}  // namespace
}  // namespace kasumi
