// kasumi haze as called by a curator.
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "pipeline/lab/haze/haze_window.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/environment.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 160, kHeight = 100;

// A near board (4 m) in front of a far wall (40 m) that fills the picture.
float range_at(int x, int y) {
  return x > 40 && x < 80 && y > 30 ? 4.0F : 40.0F;
}
Rgb8 colour_at(int x, int y) {
  if (range_at(x, y) < 20.0F) return (x / 2) % 2 == 0 ? Rgb8(250, 60, 30) : Rgb8(20, 20, 20);
  return (x / 2 + y / 2) % 2 == 0 ? Rgb8(40, 90, 160) : Rgb8(10, 20, 40);
}

Result<> write_pfm(const std::filesystem::path& path, const std::function<float(int, int)>& value) {
  const auto header = fmt::format("Pf\n{} {}\n-1.0\n", kWidth, kHeight);
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  for (int y = kHeight - 1; y >= 0; --y)
    for (int x = 0; x < kWidth; ++x) {
      const float v = value(x, y);
      bytes.resize(bytes.size() + sizeof v);
      std::memcpy(bytes.data() + bytes.size() - sizeof v, &v, sizeof v);
    }
  return write_file(path, bytes);
}

class HazeCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = test_folder("haze");
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    Image<Rgb8> picture(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) picture.at(x, y) = colour_at(x, y);
    ASSERT_TRUE(write_png(folder / "board.png", picture));
    ASSERT_TRUE(write_pfm(folder / "depth.pfm", range_at));
    ASSERT_TRUE(write_pfm(folder / "disparity.pfm", [](int x, int y) { return 400.0F / range_at(x, y) - 5.0F; }));
  }
  static std::string in_folder(const std::string& name) { return (folder / name).string(); }
  static std::string board() {
    return fmt::format("haze {} --depth {} --indoors --airlight .6,.7,.8", in_folder("board.png"),
                       in_folder("depth.pfm"));
  }
  static Image<Rgb8> read(const std::string& name) { return to_rgb8(read_photograph(folder / name).value()); }
  static std::filesystem::path folder;
};
std::filesystem::path HazeCommand::folder;

double linear(std::uint8_t encoded) {
  const double v = encoded / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

// Mean light and contrast of one colour in a part of a picture.
struct Part {
  double mean = 0.0, contrast = 0.0;
};
Part part_of(const Image<Rgb8>& picture, int left, int top, int right, int bottom, int channel) {
  double sum = 0.0, square = 0.0, count = 0.0;
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      const double v = linear(picture.at(x, y)[channel]);
      sum += v, square += v * v, count += 1.0;
    }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(square / count - mean * mean, 0.0))};
}

TEST_F(HazeCommand, FadesByTheEquationsBlursTheFarAndKeepsTheNear) {
  const auto outcome =
      run_kasumi(board() + fmt::format(" --kappa-a .3 --kappa-s .5 --lambda 8 --out {}", in_folder("made.png")));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("matched"), HasSubstr("passes"), HasSubstr("range to 40 m")));
  const auto before = read("board.png"), after = read("made.png");
  const double left = std::exp(-0.8);  // the wall is the farthest
  const auto wall = part_of(before, 100, 10, 150, 90, 2), hazed = part_of(after, 100, 10, 150, 90, 2);
  EXPECT_NEAR(hazed.mean, wall.mean * left + 0.8 * (1.0 - left), 0.005);
  EXPECT_LT(hazed.contrast, 0.05 * wall.contrast * left) << "5.7 px over squares of two";
  const double near_left = std::exp(-0.8 * 0.1);
  const auto near = part_of(before, 50, 50, 70, 90, 0), near_hazed = part_of(after, 50, 50, 70, 90, 0);
  EXPECT_NEAR(near_hazed.mean, near.mean * near_left + 0.6 * (1.0 - near_left), 0.01);
  EXPECT_GT(near_hazed.contrast, 0.5 * near.contrast * near_left) << "1.2 px, of which 1 px is the picture's own";
}

TEST_F(HazeCommand, CpuDisparityAndExplicitSchemeGiveTheSameResult) {
  const std::string haze = " --kappa-s .5 --lambda 4";
  ASSERT_EQ(run_kasumi(board() + haze + " --out " + in_folder("gpu.png")).code, 0);
  const auto cpu = ended(0, run_kasumi(board() + haze + " --cpu --out " + in_folder("cpu.png")));
  EXPECT_THAT(cpu.out, HasSubstr("the CPU"));
  ended(0, run_kasumi(fmt::format("haze {} --disparity {} --disparity-scale 400 --disparity-offset-px 5 --indoors "
                                  "--airlight .6,.7,.8 {} --out {}",
                                  in_folder("board.png"), in_folder("disparity.pfm"), haze, in_folder("stereo.png"))));
  const auto made = read("gpu.png");
  for (const char* other : {"cpu.png", "stereo.png"}) {
    const auto picture = read(other);
    int worst = 0;
    for (std::size_t i = 0; i < made.elements().size(); ++i)
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(made.elements()[i][c] - picture.elements()[i][c]));
    EXPECT_LE(worst, 1) << other;
  }
  for (const char* scheme : {"explicit", "invariant"}) {
    const auto outcome =
        run_kasumi(board() + haze + fmt::format(" --scheme {} --out {}", scheme, in_folder("other.png")));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr(scheme));
    const auto wall = part_of(made, 110, 10, 150, 90, 2), other = part_of(read("other.png"), 110, 10, 150, 90, 2);
    EXPECT_NEAR(wall.mean, other.mean, 0.004) << scheme;
  }
}

TEST_F(HazeCommand, ASweepOfTurbiditiesBecomesPicturesAndASheet) {
  ended(0, run_kasumi(fmt::format(
               "haze {} --depth {} --indoors --airlight .6,.7,.8 --turbidity 4:20:8 --out {} --sheet {}",
               in_folder("board.png"), in_folder("depth.pfm"), in_folder("sweep"), in_folder("sheet.png"))));
  for (const char* name : {"board.T4.00.png", "board.T12.00.png", "board.T20.00.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / "sweep" / name)) << name;
  EXPECT_GT(read("sheet.png").width(), 2 * kWidth);
  const auto thin = part_of(read("sweep/board.T4.00.png"), 100, 10, 150, 90, 2),
             thick = part_of(read("sweep/board.T20.00.png"), 100, 10, 150, 90, 2);
  EXPECT_GT(thick.mean, thin.mean) << "40 m of it";
}

TEST_F(HazeCommand, AKnownAerosolIsGivenByItsOpticalDepth) {
  ended(0, run_kasumi(fmt::format(
               "haze {} --depth {} --indoors --airlight .6,.7,.8 --aod 0.6:1.8:0.6 --aerosol maritime --out {}",
               in_folder("board.png"), in_folder("depth.pfm"), in_folder("aods"))));
  for (const char* name : {"board.AOD0.600.png", "board.AOD1.200.png", "board.AOD1.800.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / "aods" / name)) << name;
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("haze {} --depth {} --aod 3 --turbidity 4 --aerosol fog --out {}",
                                              in_folder("board.png"), in_folder("depth.pfm"), in_folder("x.png"))))
                  .err,
              HasSubstr("--aerosol"));
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("haze {} --depth {} --aod 3 --turbidity 4 --out {}",
                                              in_folder("board.png"), in_folder("depth.pfm"), in_folder("x.png"))))
                  .err,
              AllOf(HasSubstr("--aod 3: expected an optical depth of 0 to 1.8"), HasSubstr("one of them")));
}

TEST_F(HazeCommand, ReportsAllProblemsAtOnce) {
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("haze {} --disparity {} --turbidity 40,x --kappa-a .2 --out {}",
                                              in_folder("board.png"), in_folder("nothing.pfm"), in_folder("x.png"))))
                  .err,
              AllOf(HasSubstr("--turbidity 40"), HasSubstr("--turbidity x"), HasSubstr("--kappa-a"),
                    HasSubstr("--disparity-scale"), HasSubstr("nothing.pfm"), HasSubstr("--airlight")));
  EXPECT_EQ(run_kasumi(board() + " --kappa-s .5").code, 2) << "nothing to write";
  EXPECT_FALSE(std::filesystem::exists(folder / "x.png"));
}

// What is told of distances, and sky that the map tells where no share of the picture would.
TEST_F(HazeCommand, SaysWhatTheDistancesAreAndTakesFarAwayForSky) {
  ASSERT_TRUE(write_pfm(folder / "sky.pfm", [](int x, int y) { return y < 2 && x > 100 ? 1e10F : range_at(x, y); }));
  const auto outcome =
      ended(0, run_kasumi(fmt::format("haze {} --depth {} --airlight .6,.7,.8 --kappa-s .5 --out {}",
                                      in_folder("board.png"), in_folder("sky.pfm"), in_folder("sky.png"))));
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("4 to 40 m in 99.3 % of the picture, sky in 0.7 %, nothing known in 0.0 %"),
                                 HasSubstr("range to 40 m; 0 holes filled (0.0 % of the picture), sky 0.7 %")));
  ASSERT_TRUE(write_pfm(folder / "nothing.pfm", [](int, int) { return 0.0F; }));
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("haze {} --depth {} --airlight .6,.7,.8 --kappa-s .5 --out {}",
                                              in_folder("board.png"), in_folder("nothing.pfm"), in_folder("x.png"))))
                  .err,
              HasSubstr("nothing is known in any pixel"));
}

TEST_F(HazeCommand, NearnessNeedsItsScale) {
  ASSERT_TRUE(write_pfm(folder / "near.pfm", [](int x, int y) { return (1.0F / range_at(x, y) - 0.005F) / 0.01F; }));
  const auto haze = fmt::format("haze {} --inverse-depth {} --indoors --airlight .6,.7,.8 --kappa-s .5 --out {}",
                                in_folder("board.png"), in_folder("near.pfm"), in_folder("near.png"));
  EXPECT_THAT(ended(2, run_kasumi(haze)).err, HasSubstr("--inverse-scale"));
  const auto made = ended(0, run_kasumi(haze + " --inverse-scale .01 --inverse-offset .005"));
  EXPECT_THAT(made.out, HasSubstr("range to 40 m"));
}

TEST_F(HazeCommand, IndoorsNeedsNoSky) {
  const auto outcome =
      ended(0, run_kasumi(fmt::format("haze {} --depth {} --indoors --kappa-s .5 --out {}", in_folder("board.png"),
                                      in_folder("depth.pfm"), in_folder("room.png"))));
  EXPECT_THAT(outcome.out, HasSubstr("of the picture's brightest hundredth"));
}

TEST_F(HazeCommand, TheWindowFollowsItsKeys) {
  HazeOptions options;
  options.picture = in_folder("board.png");
  options.distances.depth = in_folder("depth.pfm");
  options.indoors = true;
  options.scatterings = {"0.5"};
  options.airlight = {0.6, 0.7, 0.8};
  const auto task = must(haze_task(options));
  auto window = HazeWindow::open(*task);
  if (!window) {
    const auto no_display = window.error().message;
    const EnvironmentVariable driver("SDL_VIDEODRIVER", "offscreen");
    window = HazeWindow::open(*task);
    if (!window) GTEST_SKIP() << no_display << "; " << window.error().message;
  }
  ASSERT_TRUE(window->step().value());
  EXPECT_DOUBLE_EQ(window->values().kappa_s, 0.5);
  ASSERT_TRUE(window->step("ssssaddd").value());
  EXPECT_NEAR(window->values().kappa_s, 1.0, 1e-9);
  EXPECT_NEAR(window->values().kappa_a, 0.02, 1e-12);
  EXPECT_NEAR(window->values().lambda, 15.0 * std::pow(2.0, 0.75), 1e-9);
  ASSERT_TRUE(window->step("z").value());
  EXPECT_EQ(window->values().kappa_a, 0.0);
  ASSERT_TRUE(window->step(std::string(30, 'd')).value()) << "a blur larger than the picture is reported, not drawn";
  ASSERT_TRUE(window->step("r").value());
  EXPECT_DOUBLE_EQ(window->values().kappa_s, 0.5);
  EXPECT_THAT(caption_of(window->values()), HasSubstr("kappa_s 0.500"));
}

TEST(HazeKeys, TurnTWhenTurbidityIsGiven) {
  const HazeValues given{Turbidity{4.0}, 0.0, 0.0, 15.0};
  auto haze = given;
  EXPECT_TRUE(adjust_haze(haze, given, 's'));
  EXPECT_GT(haze.turbidity->value, 4.0);
  EXPECT_FALSE(adjust_haze(haze, given, 'a')) << "air does not absorb";
  for (int i = 0; i < 100; ++i) adjust_haze(haze, given, 'x');
  EXPECT_EQ(*haze.turbidity, kLowestTurbidity);
  EXPECT_FALSE(adjust_haze(haze, given, 'w'));
  EXPECT_TRUE(adjust_haze(haze, given, 'r'));
  EXPECT_EQ(*haze.turbidity, *given.turbidity);
}

}  // namespace
}  // namespace kasumi
