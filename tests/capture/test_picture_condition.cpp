// Row 12 of docs/faults.md: a covered lens, a frozen or white picture, and what only resembles them.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "capture/reconnecting_source.hpp"
#include "tests/capture/known_frames.hpp"
#include "tests/capture/v4l2/fake_camera.hpp"

namespace kasumi {
namespace {

// An NV12 picture of mean brightness `level`, with sensor noise.
struct Sensor {
  std::function<int(int x, int y)> level;
  double noise = 1.5;
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(7);

  std::vector<std::vector<std::uint8_t>> operator()(std::uint32_t) const {
    std::vector<std::uint8_t> bytes(160 * 120 * 3 / 2, 128);
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        double sum = 0.0;  // a sum of four: close enough to normal
        for (int i = 0; i < 4; ++i) sum += static_cast<double>((*random)() >> 11) * 0x1p-53 - 0.5;
        const double value = level(x, y) + noise * sum * 1.732;
        bytes[static_cast<std::size_t>(y * 160 + x)] =
            static_cast<std::uint8_t>(std::clamp(std::lround(value), 0l, 255l));
      }
    return {std::move(bytes)};
  }
};

class Conditions : public testing::Test {
 protected:
  Conditions() {
    camera.interval = 200ms;  // generating noise is slow
    camera.content = [this](std::uint32_t number) {
      if (!repeats) last = sensor(number);
      return last;
    };
    SourceOpener opener{"scene camera",
                        [this]() -> Result<std::unique_ptr<FrameSource>> {
                          V4l2Options options{"/dev/v4l/by-id/fake", {}};
                          options.request.width = 160;
                          options.request.height = 120;
                          auto opened = open_v4l2_source(camera.open(), options, clock);
                          if (!opened) return fail(opened.error());
                          return std::move(*opened);
                        },
                        {}};
    source = reconnecting(std::move(opener), clock);
  }
  void run(Duration time) {
    for (const auto until = clock.now() + time; clock.now() < until;) (void)source->next(clock.now() + 100ms);
  }
  PictureCondition condition() const { return source->health().condition; }
  Duration until(PictureCondition wanted) {
    const auto from = clock.now();
    while (condition() != wanted && clock.now() - from < 2min) run(50ms);
    return clock.now() - from;
  }

  FastForwardClock clock{Utc{}};
  FakeCamera camera{{{V4L2_PIX_FMT_NV12, 160, 120, {{1, 5}}}}, clock};
  Sensor sensor{[](int x, int y) { return 60 + x / 2 + y / 2; }};
  bool repeats = false;
  std::vector<std::vector<std::uint8_t>> last;
  std::unique_ptr<ReconnectingSource> source;
};

void print_row_12(std::string_view what, Duration time, Duration least, Duration most) {
  std::cout << fmt::format("row 12: {}: {:.2f} s (allowed {:.0f} to {:.0f})\n", what, to_seconds(time),
                           to_seconds(least), to_seconds(most));
  EXPECT_GE(time, least) << what;
  EXPECT_LE(time, most) << what;
}

TEST_F(Conditions, AStillSceneUnderNoiseIsNotFrozen) {
  run(90s);
  EXPECT_EQ(condition(), PictureCondition::normal);
}

TEST_F(Conditions, APictureThatRepeatsBitForBitIsFrozenUntilItChanges) {
  run(5s);
  repeats = true;
  print_row_12("frozen picture noticed", until(PictureCondition::frozen), 28s, 32s);
  repeats = false;
  print_row_12("it moves", until(PictureCondition::normal), 0s, 2s);
  EXPECT_EQ(source->health().opened, 1u) << "noticed without reopening the camera";
}

TEST_F(Conditions, ACleanSkyThatRepeatsForAWhileIsNotFrozen) {
  run(2s);
  for (int i = 0; i < 4; ++i) {
    repeats = true;
    run(25s);
    EXPECT_EQ(condition(), PictureCondition::normal);
    repeats = false;
    run(2s);
    EXPECT_EQ(condition(), PictureCondition::normal);
  }
}

TEST_F(Conditions, ACoveredLensIsNoticedThroughItsNoise) {
  run(5s);
  sensor.level = [](int, int) { return 14; };
  sensor.noise = 12.0;  // the camera turns its gain up
  print_row_12("covered lens noticed", until(PictureCondition::covered), 28s, 32s);
  sensor.level = [](int x, int) { return 60 + x / 2; };
  print_row_12("cover gone", until(PictureCondition::normal), 0s, 2s);
}

TEST_F(Conditions, ACoveredLensStaysCoveredWhenTheCameraIsReopened) {
  sensor.level = [](int, int) { return 14; };
  run(40s);
  EXPECT_EQ(condition(), PictureCondition::covered);
  camera.fail_queue();
  run(5s);
  EXPECT_EQ(source->health().opened, 2u);
  EXPECT_EQ(condition(), PictureCondition::covered);
}

TEST_F(Conditions, ANightWithALampIsNotACoveredLens) {
  sensor.level = [](int x, int y) { return x / 10 == 5 && y / 10 == 5 ? 200 : 14; };
  run(60s);
  EXPECT_EQ(condition(), PictureCondition::normal);
}

TEST_F(Conditions, FogIsNeitherACoveredLensNorAWhiteOut) {
  for (const int grey : {60, 130, 210}) {
    sensor.level = [grey](int, int) { return grey; };
    run(60s);
    EXPECT_EQ(condition(), PictureCondition::normal) << grey;
  }
}

TEST_F(Conditions, AWhiteOutIsNoticedWhetherSaturationIs255Or235) {
  for (const int white : {255, 240}) {
    run(5s);
    sensor.level = [white](int x, int) { return x < 4 ? 120 : white; };
    sensor.noise = white == 255 ? 0.0 : 1.5;
    print_row_12("white-out noticed", until(PictureCondition::white_out), 28s, 32s);
    sensor = Sensor{[](int x, int y) { return 60 + x / 2 + y / 2; }};
    print_row_12("white-out over", until(PictureCondition::normal), 0s, 2s);
  }
}

}  // namespace
}  // namespace kasumi
