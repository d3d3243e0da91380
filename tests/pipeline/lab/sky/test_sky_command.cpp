// `kasumi sky` as a user types it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include <opencv2/imgcodecs.hpp>

#include "pipeline/lab/sky/sky_options.hpp"
#include "pipeline/site/files/light_file.hpp"
#include "tests/environment.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::filesystem::path place(const std::string& name) {
  const auto path = test_folder("sky-" + name);
  std::filesystem::remove_all(path);
  return path;
}

TEST(SkyCommand, DrawsEachProjectionWithAndWithoutAGpu) {
  for (const std::string projection : {"perspective", "fisheye", "equirectangular"}) {
    const auto file = place(projection + ".png");
    ended(0, run_kasumi(fmt::format(
                 "sky --cpu --projection {} --size 64x48 --turbidity 3 --altitude-m 2000 --sun-zenith-deg 60 --out {}",
                 projection, file.string())));
    const cv::Mat picture = cv::imread(file.string());
    EXPECT_EQ(picture.cols, 64);
    EXPECT_EQ(picture.rows, 48);
  }
}

TEST(SkyCommand, DrawsAGivenAerosol) {
  const auto file = place("smoke.pfm"), plain = place("plain.pfm");
  const std::string sky = "sky --projection fisheye --size 33x33 --sun-zenith-deg 50 --out ";
  ended(0, run_kasumi(sky + file.string() + " --aod 0.6 --aerosol smoke"));
  ASSERT_EQ(run_kasumi(sky + plain.string() + " --aod 0").code, 0);
  const auto zenith = [](const std::filesystem::path& of) {
    return cv::imread(of.string(), cv::IMREAD_UNCHANGED).at<cv::Vec3f>(16, 16);  // blue, green, red
  };
  DomeRequest request;
  request.sun = direction_from(from_degrees(50.0), from_degrees(180.0));
  request.like = Aerosol{0.0, natural_exponent(AerosolKind::smoke), AerosolKind::smoke};
  request.turbidity = {turbidity_of({0.6, natural_exponent(AerosolKind::smoke), AerosolKind::smoke})};
  const glm::dvec3 expected = DomePainter(sky_scene(request)).sky({0.0, 0.0, 1.0});
  EXPECT_NEAR(double{zenith(file)[1]} / expected.g, 1.0, 1e-4);
  EXPECT_LT(zenith(plain)[2], 0.5F * zenith(file)[2]) << "molecules alone";
  const auto wrong = ended(2, run_kasumi(sky + file.string() + " --aod 3 --turbidity 2 --model nielsen2003"));
  for (const char* words : {"--aod 3: expected 0 to 1.8", "--turbidity and --aod: expected only one", "--model dome"})
    EXPECT_THAT(wrong.err, HasSubstr(words));
}

TEST(SkyCommand, WritesTheRadiance) {
  const auto file = place("light.pfm");
  const auto done =
      run_kasumi(fmt::format("sky --projection fisheye --size 33x33 --sun-zenith-deg 50 --out {}", file.string()));
  ASSERT_EQ(done.code, 0) << done.err;
  const cv::Mat light = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(light.type(), CV_32FC3);
  DomeRequest request;
  request.turbidity = {2.5};
  request.sun = direction_from(from_degrees(50.0), from_degrees(180.0));
  const glm::dvec3 zenith = DomePainter(sky_scene(request)).sky({0.0, 0.0, 1.0});
  const auto middle = light.at<cv::Vec3f>(16, 16);  // blue, green, red
  EXPECT_NEAR(double{middle[2]} / zenith.r, 1.0, 1e-4);
  EXPECT_NEAR(double{middle[0]} / zenith.b, 1.0, 1e-4);
}

TEST(SkyCommand, WritesExrOrNamesTheAlternative) {
  const auto file = place("light.exr");
  Image<glm::vec3> light(4, 3, glm::vec3(1.0f, 2.0f, 30000.0f));
  const auto done = write_light_file(file, light);
  if (!done) {
    EXPECT_THAT(done.error().message, HasSubstr(".pfm holds the same light"));
    return;
  }
  const EnvironmentVariable exr("OPENCV_IO_ENABLE_OPENEXR", "1");
  const cv::Mat back = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(back.type(), CV_32FC3);
  EXPECT_EQ(back.at<cv::Vec3f>(1, 1)[0], 30000.0f);
}

TEST(SkyCommand, ReportsAllProblemsAtOnce) {
  const auto done = ended(2, run_kasumi("sky --turbidity 0.5 --altitude-m 40000 --size big --projection cube "
                                        "--sun-zenith-deg 120 --model clouds --out a.gif --day x.mp4"));
  for (const char* words : {"--turbidity 0.5: expected 1.7 to 10", "--altitude-m 40000: expected 0 to 30000",
                            "--size big: expected WIDTHxHEIGHT", "--projection cube: expected fisheye",
                            "--sun-zenith-deg 120: expected 0 to 92", "--model clouds: expected dome",
                            "--out a.gif: expected a name that ends in", "--day: expected --site and --utc"})
    EXPECT_THAT(done.err, HasSubstr(words));
}

TEST(SkyCommand, RequiresAnOutput) {
  EXPECT_THAT(ended(2, run_kasumi("sky")).err, HasSubstr("expected --out, --sheet, --day, --compare or --window"));
}

TEST(SkyCommand, ReportsThatItIsNight) {
  EXPECT_THAT(ended(2, run_kasumi("sky --site 34.69,135.80 --utc 2026-06-21T15:00:00Z --out a.png")).err,
              HasSubstr("below the horizon at --site"));
}

TEST(SkyCommand, WritesASheetOfTurbidityByAltitude) {
  const auto file = place("sheet.png");
  ended(0, run_kasumi(fmt::format(
               "sky --cpu --projection fisheye --size 40x40 --turbidity 2,5,9 --altitude-m 0,8000 --sheet {}",
               file.string())));
  const cv::Mat sheet = cv::imread(file.string());
  EXPECT_EQ(sheet.cols, 3 * 46 + 6);
  EXPECT_EQ(sheet.rows, 2 * 46 + 6);
}

TEST(SkyCommand, FollowsADayFromDawnToDusk) {
  const auto folder = place("day");
  ended(0, run_kasumi(fmt::format("sky --cpu --projection fisheye --size 24x24 --site 34.69,135.80 --utc "
                                  "2026-06-21T15:00:00Z --frames 5 --day {}",
                                  folder.string())));
  int pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    pictures += entry.path().extension() == ".png" ? 1 : 0;
  EXPECT_EQ(pictures, 5);
}

TEST(SkyCommand, ComparesWithTheEarlierSkies) {
  const auto file = place("compare.png");
  const auto done =
      ended(0, run_kasumi(fmt::format("sky --cpu --size 40x30 --sun-zenith-deg 60 --compare {}", file.string())));
  for (const char* kind : {"dome", "preetham1999", "hoffman-preetham2002", "nielsen2003"})
    EXPECT_THAT(done.out, HasSubstr(kind));
  EXPECT_FALSE(cv::imread(file.string()).empty());
}

}  // namespace
}  // namespace kasumi
