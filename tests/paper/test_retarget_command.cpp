// kasumi retarget as called by a researcher.
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "calib/distances/distance_map.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "pipeline/site/files/picture_source.hpp"
#include "tests/environment.hpp"
#include "tests/estimator/photograph/hazy_land.hpp"
#include "tests/must.hpp"
#include "tests/paper/generated_scene.hpp"
#include "tests/picture_difference.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Grey PFM: rows from the bottom up, little endian.
Result<> write_pfm(const std::filesystem::path& path, const Image<float>& values) {
  const auto header = fmt::format("Pf\n{} {}\n-1.0\n", values.width(), values.height());
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  for (int y = values.height() - 1; y >= 0; --y) {
    const auto at = bytes.size(), length = sizeof(float) * static_cast<std::size_t>(values.width());
    bytes.resize(at + length);
    std::memcpy(bytes.data() + at, values.row(y), length);
  }
  return write_file(path, bytes);
}

class RetargetCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = test_folder("retarget");
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const auto land = land_at({});
    const Scene source = scene_at(land, 1.9, 21);
    target = scene_at(land, 2.94, 22).picture;
    ASSERT_TRUE(write_png(folder / "source.png", source.picture));
    ASSERT_TRUE(write_png(folder / "target.png", target));
    ASSERT_TRUE(write_pfm(folder / "depth.pfm", source.distance_m));
    const auto& camera = source.camera;
    const auto lens = pinhole_model(*camera.lens).value();
    const auto text = fmt::format(
        "calibration = 1\n[site]\nlatitude_deg = 34.2\nlongitude_deg = 135.6\naltitude_m = {}\n"
        "[scene]\nwidth = {}\nheight = {}\nheading_deg = {}\npitch_deg = {}\nresponse = \"srgb\"\n"
        "colour_space = \"sensor\"\nwhite_balance = [{}, {}, {}]\n"
        "[scene.lens]\nmodel = \"pinhole\"\nfocal_px = [{}, {}]\ncentre_px = [{:.6f}, {:.6f}]\n"
        "distortion = [{:.6f}, 0.0, 0.0, 0.0, 0.0]\n"
        "[scene.vignetting]\nradius_px = {}\ncoefficients = [{:.6f}, {:.6f}, {:.6f}]\n",
        source.altitude_m, camera.width, camera.height, source.mounting.heading_deg, source.mounting.pitch_deg,
        camera.white_balance.r, camera.white_balance.g, camera.white_balance.b, lens.focal_px.x, lens.focal_px.y,
        lens.centre.x, lens.centre.y, lens.distortion[0], camera.vignetting.radius_px,
        camera.vignetting.coefficients[0], camera.vignetting.coefficients[1], camera.vignetting.coefficients[2]);
    ASSERT_TRUE(write_text_file(folder / "camera.toml", text));
  }
  static std::string in_folder(const std::string& name) { return (folder / name).string(); }
  static std::string known() {
    return fmt::format("{} --camera {} --depth {} --source-turbidity 1.9 --sun-zenith-deg 50 --sun-azimuth-deg 230",
                       in_folder("source.png"), in_folder("camera.toml"), in_folder("depth.pfm"));
  }
  static Image<Rgb8> read(const std::string& name) { return to_rgb8(read_photograph(folder / name).value()); }
  static std::filesystem::path folder;
  static Image<Rgb8> target;
};
std::filesystem::path RetargetCommand::folder;
Image<Rgb8> RetargetCommand::target;

TEST_F(RetargetCommand, ShowsTheSceneAsItIsInThatAir) {
  ended(0, run_kasumi(fmt::format("retarget {} --turbidity 2.94 --target-picture {} --out {}", known(),
                                  in_folder("target.png"), in_folder("made.png"))));
  EXPECT_LE(difference(read("made.png"), target).mean, 2.0);
  EXPECT_GT(difference(read("source.png"), target).mean, 10.0) << "otherwise the test shows nothing";
  EXPECT_TRUE(std::filesystem::exists(folder / "made.restored-mask.png"));
  EXPECT_EQ(std::filesystem::read_symlink(folder / "made.restored.png"), "made.restored-mask.png") << "the old name";
}

// Without a picture of the target the sky model gives the brightness of the haze.
TEST_F(RetargetCommand, FindsTheLightFromInfinityByTheSkyModel) {
  ended(0, run_kasumi(fmt::format("retarget {} --turbidity 1.9 --out {}", known(), in_folder("same.png"))));
  EXPECT_LE(difference(read("same.png"), read("source.png")).mean, 0.01) << "the same air leaves the picture unchanged";
}

TEST_F(RetargetCommand, MakesAFolderASheetAndAFilmOfSeveralAirs) {
  const auto outcome =
      run_kasumi(fmt::format("retarget {} --turbidity clear,2:4:1 --out {} --sheet {} --film {}", known(),
                             in_folder("several"), in_folder("sheet.png"), in_folder("film.mp4")));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* name : {"source.clear.png", "source.T2.00.png", "source.T3.00.png", "source.T4.00.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / "several" / name)) << name;
  EXPECT_GT(std::filesystem::file_size(folder / "film.mp4"), 1000u);
  const auto sheet = read("sheet.png");
  EXPECT_GE(sheet.width() * sheet.height(), 5 * 320 * 180) << "the source and four airs";
}

TEST_F(RetargetCommand, WritesAirlightAndDirectTransmissionApart) {
  const auto outcome =
      run_kasumi(fmt::format("retarget {} --turbidity 2.94 --terms --out {}", known(), in_folder("whole.png")));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto whole = read_photograph(folder / "whole.png").value(),
             airlight = read_photograph(folder / "whole.airlight.png").value(),
             direct = read_photograph(folder / "whole.direct.png").value();
  EXPECT_LT(airlight.quantum, 1.0 / 60000.0) << "16 bits, so that the sum holds to the picture's own";
  const auto srgb = Response::srgb();
  double largest = 0.0;
  glm::dvec3 of_airlight{0.0}, of_direct{0.0};
  for (std::size_t i = 0; i < whole.encoded.elements().size(); ++i) {
    const auto a = srgb.to_light(glm::dvec3(airlight.encoded.elements()[i])),
               d = srgb.to_light(glm::dvec3(direct.encoded.elements()[i]));
    of_airlight += a;
    of_direct += d;
    const auto off = 255.0 * glm::abs(srgb.to_encoded(glm::min(a + d, 1.0)) - glm::dvec3(whole.encoded.elements()[i]));
    largest = std::max({largest, off.r, off.g, off.b});
  }
  EXPECT_LE(largest, 0.51) << "half a step of the picture's 8 bits";
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(of_airlight[c] > 0.0 && of_direct[c] > 0.0);
  const auto nowhere =
      run_kasumi(fmt::format("retarget {} --turbidity 2.94 --terms --sheet {}", known(), in_folder("never.png")));
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("--terms: expected --out"));
}

TEST_F(RetargetCommand, TakesAKnownAerosolByItsOpticalDepth) {
  ended(
      0,
      run_kasumi(fmt::format(
          "retarget {} --depth {} --source-aod 0.1 --aod 0.2:0.4:0.2,clear --aerosol dust --airlight .5,.6,.7 --out {}",
          in_folder("source.png"), in_folder("depth.pfm"), in_folder("aods"))));
  for (const char* name : {"source.clear.png", "source.AOD0.200.png", "source.AOD0.400.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / "aods" / name)) << name;
  const auto wrong =
      ended(2, run_kasumi(fmt::format(
                   "retarget {} --depth {} --source-aod 0.1 --source-turbidity 2 --aod 3 --turbidity 2 --out {}",
                   in_folder("source.png"), in_folder("depth.pfm"), in_folder("never.png"))));
  EXPECT_THAT(wrong.err, HasSubstr("--aod 3: expected an optical depth of 0 to 1.8"));
  EXPECT_THAT(wrong.err, HasSubstr("expected --turbidity or --aod"));
  EXPECT_THAT(wrong.err, HasSubstr("expected one of --source-turbidity T, --source-aod"));
}

TEST_F(RetargetCommand, ReportsAllProblemsAtOnceAndWritesNothing) {
  const auto out = in_folder("never.png");
  const auto outcome =
      ended(2, run_kasumi(fmt::format("retarget {} --depth {} --turbidity 99,2:1:1 --utc yesterday --out {}",
                                      in_folder("source.png"), in_folder("no-depth.pfm"), out)));
  EXPECT_THAT(outcome.err, HasSubstr("--turbidity 99: expected a T of 1.7 to 20"));
  EXPECT_THAT(outcome.err, HasSubstr("--turbidity 2:1:1"));
  EXPECT_THAT(outcome.err, HasSubstr("--utc yesterday"));
  EXPECT_THAT(outcome.err, HasSubstr("no-depth.pfm"));
  EXPECT_THAT(outcome.err, HasSubstr("--source-turbidity"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

// A film from a fixed camera: the same number and rate of frames, each retargeted like a picture.
TEST_F(RetargetCommand, TakesAFilmAndWritesOneForEachAir) {
  {
    auto film = must(open_film(folder / "day.mp4", 5.0));
    for (int i = 0; i < 4; ++i)
      if (const auto put = (*film)->put(read("source.png")); !put) GTEST_SKIP() << put.error().message;
    ASSERT_TRUE((*film)->finish());
  }
  const auto rest = known().substr(known().find(' '));
  ended(0, run_kasumi(fmt::format("retarget {} {} --turbidity 2.5,4 --film {}", in_folder("day.mp4"), rest,
                                  in_folder("other.mp4"))));
  ASSERT_EQ(run_kasumi(fmt::format("retarget {} --turbidity 4 --out {}", known(), in_folder("four.png"))).code, 0);
  const auto film = must(open_pictures({in_folder("other.T4.00.mp4")}));
  EXPECT_NEAR((*film)->frames_per_second().value_or(0.0), 5.0, 0.01);
  int frames = 0;
  for (auto next = (*film)->next(); next && *next; next = (*film)->next(), ++frames)
    EXPECT_LE(difference(to_rgb8((*next)->photograph), read("four.png")).mean, 5.0) << "two codecs between";
  EXPECT_EQ(frames, 4);
  EXPECT_TRUE(std::filesystem::exists(folder / "other.T2.50.mp4"));
  EXPECT_FALSE(std::filesystem::exists(folder / "other.mp4"));
}

TEST_F(RetargetCommand, TakesAFolderOfFramesByName) {
  std::filesystem::create_directories(folder / "frames");
  for (const char* name : {"b.png", "a.png"}) ASSERT_TRUE(write_png(folder / "frames" / name, read("source.png")));
  const auto rest = known().substr(known().find(' '));
  ended(0, run_kasumi(fmt::format("retarget {} {} --turbidity 2.94 --out {}", in_folder("frames"), rest,
                                  in_folder("made-frames"))));
  for (const char* name : {"a.T2.94.png", "b.T2.94.png", "a.T2.94.restored.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / "made-frames" / name)) << name;
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("retarget {} {} --turbidity 2.94 --sheet {}", in_folder("frames"), rest,
                                              in_folder("never.png"))))
                  .err,
              HasSubstr("a sheet keeps all of them in memory"));
}

// One wall without a top, seen through a narrow lens, is nearly one distance for all pixels.
TEST_F(RetargetCommand, TakesDistancesFromGroundAndWalls) {
  ASSERT_TRUE(write_text_file(folder / "planes.toml", "[[walls]]\ndistance_m = 6000\nazimuth_deg = 4\n"));
  const auto command =
      fmt::format("retarget {} --fov-deg 20 --source-turbidity 1.9 --turbidity 4 ", in_folder("source.png"));
  const auto by_wall =
      run_kasumi(fmt::format("{} --planes {} --out {}", command, in_folder("planes.toml"), in_folder("wall.png")));
  ASSERT_EQ(by_wall.code, 0) << by_wall.err;
  ASSERT_EQ(run_kasumi(fmt::format("{} --distance-m 6000 --out {}", command, in_folder("one.png"))).code, 0);
  EXPECT_LE(difference(read("wall.png"), read("one.png")).mean, 1.0);
  EXPECT_GT(difference(read("wall.png"), read("source.png")).mean, 5.0) << "otherwise the test shows nothing";
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("{} --planes {} --distance-m 6000 --out {}", command,
                                              in_folder("planes.toml"), in_folder("never.png"))))
                  .err,
              HasSubstr("expected one of --depth FILE, --planes FILE"));
}

TEST_F(RetargetCommand, ReadsExrAsItReadsPfm) {
  const EnvironmentVariable exr("OPENCV_IO_ENABLE_OPENEXR", "1");
  const auto distances = read_distances(folder / "depth.pfm", {}, 320, 180).value().metres;
  cv::Mat map(distances.height(), distances.width(), CV_32FC1);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) map.at<float>(y, x) = distances.at(x, y);
  bool written = false;
  try {
    written = cv::imwrite(in_folder("depth.exr"), map);
  } catch (const cv::Exception&) {
  }
  if (!written) GTEST_SKIP() << "this OpenCV has no EXR";
  auto command = known();
  command.replace(command.find("depth.pfm"), 9, "depth.exr");
  ASSERT_EQ(run_kasumi(fmt::format("retarget {} --turbidity 3 --out {}", known(), in_folder("by-pfm.png"))).code, 0);
  ended(0, run_kasumi(fmt::format("retarget {} --turbidity 3 --out {}", command, in_folder("by-exr.png"))));
  EXPECT_EQ(difference(read("by-exr.png"), read("by-pfm.png")).mean, 0.0);
}

TEST_F(RetargetCommand, TakesADepthOfAnotherSizeButOfNoOtherShape) {
  ASSERT_TRUE(write_pfm(folder / "same.pfm", Image<float>(320, 180, 100.0F)));
  ASSERT_TRUE(write_pfm(folder / "half.pfm", Image<float>(160, 90, 100.0F)));
  for (const char* size : {"same", "half"}) {
    const auto made =
        run_kasumi(fmt::format("retarget {} --depth {}.pfm --source-turbidity 2 --turbidity 3 --out {}.png",
                               in_folder("source.png"), in_folder(size), in_folder(size)));
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_THAT(made.out, HasSubstr("100 to 100 m in 100.0 % of the picture"));
    EXPECT_EQ(made.out.find("resampled from 160 x 90") != std::string::npos, std::string(size) == "half") << made.out;
  }
  EXPECT_EQ(difference(read("same.png"), read("half.png")).mean, 0.0);
  ASSERT_TRUE(write_pfm(folder / "small.pfm", Image<float>(32, 20, 100.0F)));
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("retarget {} --depth {} --source-turbidity 2 --turbidity 3 --out {}",
                                              in_folder("source.png"), in_folder("small.pfm"), in_folder("never.png"))))
                  .err,
              HasSubstr("320 x 180 (it is 32 x 20)"));
}

// Grey haze that leaves half of each surface, every neighbourhood with something black in it: .9 of the haze is
// removed, so that black keeps 1 - .5 / .55 of the light from infinity.
TEST_F(RetargetCommand, RemovesHazeWhenOnlyThePictureIsKnown) {
  const auto srgb = Response::srgb();
  const auto pixel = [&](double light) {
    return Rgb8(static_cast<std::uint8_t>(std::lround(255.0 * srgb.to_encoded(glm::dvec3{light}).g)));
  };
  constexpr double kInfinity = 0.6;
  Image<Rgb8> hazy(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      hazy.at(x, y) = y < 30 ? pixel(kInfinity) : pixel(kInfinity * ((x / 2 + y / 2) % 2 == 0 ? 0.5 : 0.75));
  ASSERT_TRUE(write_png(folder / "hazy.png", hazy));
  ended(0, run_kasumi(fmt::format("retarget {} --from-haze --source-turbidity 4 --turbidity clear --out {}",
                                  in_folder("hazy.png"), in_folder("guessed.png"))));
  const auto made = read("guessed.png");
  EXPECT_NEAR(made.at(80, 80).g, pixel(kInfinity * (1.0 - 0.5 / 0.55)).g, 8.0) << "black";
  EXPECT_NEAR(made.at(82, 80).g, pixel(kInfinity * (1.0 - 0.25 / 0.55)).g, 8.0) << "grey of one half";
  EXPECT_NEAR(made.at(80, 8).g, pixel(kInfinity).g, 2.0) << "sky";
}

// Extinction of green per km under T, by M's own coefficients at the ground (M Sect 5): .0141 and .0638 at T 1.6.
double papers_green_per_km(double turbidity) {
  return 0.0141 + 0.0638 * (turbidity - 1.0) / 0.6;
}
// Smog of an exponent under two T, in closed form; its distances.
void write_smog(const std::filesystem::path& folder, double exponent) {
  HazyLand land{
      .exponent = exponent, .green_per_km = papers_green_per_km(6.0), .nearest_m = 500.0, .farthest_m = 4000.0};
  ASSERT_TRUE(write_png(folder / "smog.png", to_rgb8(drawn(land))));
  land.green_per_km = papers_green_per_km(3.0);
  land.noise = 0.0;
  ASSERT_TRUE(write_png(folder / "smog-less.png", to_rgb8(drawn(land))));
  Image<float> distance_m(kLandWidth, kLandHeight, 0.0F);
  for (int y = kLandHorizon; y < kLandHeight; ++y)
    for (int x = 0; x < kLandWidth; ++x) distance_m.at(x, y) = static_cast<float>(distance_of_row(land, y));
  ASSERT_TRUE(write_pfm(folder / "smog.pfm", distance_m));
}
// Mean of blue less red over the farther land, of 255.
double blue_over_red(const Image<Rgb8>& picture) {
  double sum = 0.0;
  int count = 0;
  for (int y = kLandHorizon + 20; y < kLandHorizon + 80; ++y)
    for (int x = 0; x < picture.width(); ++x, ++count) sum += picture.at(x, y).b - picture.at(x, y).r;
  return sum / count;
}

TEST_F(RetargetCommand, KeepsGreySmogGreyByThePictureItself) {
  write_smog(folder, 0.0);
  const auto command = fmt::format("retarget {} --depth {} --source-turbidity 6 --turbidity 3", in_folder("smog.png"),
                                   in_folder("smog.pfm"));
  const auto ours = ended(0, run_kasumi(fmt::format("{} --out {}", command, in_folder("smog-ours.png"))));
  EXPECT_THAT(ours.out, HasSubstr("by the picture"));
  const auto papers =
      run_kasumi(fmt::format("{} --scattering morales2017 --out {}", command, in_folder("smog-papers.png")));
  ASSERT_EQ(papers.code, 0) << papers.err;
  EXPECT_THAT(papers.out, testing::Not(HasSubstr("by the picture")));
  const double truth = blue_over_red(read("smog-less.png"));
  fmt::print("blue less red: {:.1f}; by the picture's exponent {:.1f}, by the papers' {:.1f}\n", truth,
             blue_over_red(read("smog-ours.png")), blue_over_red(read("smog-papers.png")));
  EXPECT_NEAR(blue_over_red(read("smog-ours.png")), truth, 3.0);
  EXPECT_GT(std::abs(blue_over_red(read("smog-papers.png")) - truth), 8.0) << "otherwise the test shows nothing";
  EXPECT_TRUE(std::filesystem::exists(folder / "smog-ours.restored.png"));
}

// Clear air: what its haze is like is not guessed.
TEST_F(RetargetCommand, SaysThatThePictureDoesNotTell) {
  const HazyLand land{.exponent = 0.0, .green_per_km = 0.02};
  ASSERT_TRUE(write_png(folder / "clear.png", to_rgb8(drawn(land))));
  for (const auto& [options, supposed] :
       {std::pair{"--distance-m 1000 --source-turbidity 6 --turbidity 3", "the papers' haze is supposed"},
        std::pair{"--distance-m 1000 --source-aod .5 --aod .2", "an exponent of 1.3 is supposed"},
        std::pair{"--from-haze --source-turbidity 6 --turbidity 3", "grey haze is supposed"}}) {
    const auto outcome =
        run_kasumi(fmt::format("retarget {} {} --out {}", in_folder("clear.png"), options, in_folder("clear-out.png")));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr(supposed));
    EXPECT_THAT(outcome.out, HasSubstr("does not determine"));
  }
}

}  // namespace
}  // namespace kasumi
