#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/lens/lens.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct Read {
  LensPtr lens;
  std::string problems;
};
Read read(const std::string& text) {
  const auto root = ConfigTable::parse(text, "camera.toml").value();
  auto lens = read_lens(root);
  const auto finished = root.finish();
  return {lens, finished ? "" : finished.error().message};
}

TEST(ReadLens, EveryModelIsReadWithItsOwnKeys) {
  const std::pair<const char*, const char*> models[] = {
      {"equidistant", "focal_px = 150\ncentre_px = [250, 240]"},
      {"equisolid", "focal_px = 150\ncentre_px = [250, 240]\nlargest_angle_deg = 100"},
      {"opencv_fisheye", "focal_px = [150, 151]\ncentre_px = [250, 240]\nk = [0.01, 0, 0, 0]"},
      {"scaramuzza", "polynomial = [-150, 0, 1e-3]\ncentre_px = [250, 240]\naffine = [1.0, 0.001, 0.0]"},
      {"pinhole", "focal_px = [150, 151]\ncentre_px = [250, 240]\ndistortion = [-0.1, 0.01, 0, 0]"}};
  for (const auto& [model, keys] : models) {
    const auto [lens, problems] = read(fmt::format("model = '{}'\n{}", model, keys));
    EXPECT_EQ(problems, "");
    EXPECT_EQ(lens->name(), model);
    EXPECT_EQ(lens->project({0.0, 0.0, 1.0}).value(), glm::dvec2(250.0, 240.0)) << model;
  }
}

TEST(ReadLens, AFieldOfViewAndItsImageCircleAreEnough) {
  for (const char* model : {"equidistant", "equisolid"}) {
    const auto [lens, problems] = read(fmt::format("model = '{}'\nfov_deg = 190\ncircle_px = [250, 240, 200]", model));
    EXPECT_EQ(problems, "");
    const double edge = from_degrees(95.0).value;
    EXPECT_NEAR(lens->project({std::sin(edge), 0.0, std::cos(edge)})->x, 450.0, 1e-9) << model;
    EXPECT_FALSE(lens->project({std::sin(edge + 0.01), 0.0, std::cos(edge + 0.01)}));
  }
}

TEST(ReadLens, AFisheyeEndsAtTheHorizonByDefault) {
  const auto lens = read("model = 'equidistant'\nfocal_px = 150\ncentre_px = [250, 240]").lens;
  EXPECT_TRUE(lens->project({1.0, 0.0, 0.0}));
  EXPECT_FALSE(lens->project({1.0, 0.0, -0.001}));
}

TEST(ReadLens, BrokenKeysAreAllNamedAndALensIsStillReturned) {
  const std::pair<const char*, const char*> cases[] = {
      {"model = 'banana'", "model = 'banana': expected one of \"equidistant\""},
      {"model = 'equidistant'\nfocal_px = 0\ncentre_px = [1, 2]", "focal_px = 0: expected a number from 1"},
      {"model = 'equidistant'\nfocal_px = 10", "centre_px is missing"},
      {"model = 'equidistant'\nfocal_px = 10\ncentre_px = [1, 2]\nlargest_angle_deg = 200", "largest_angle_deg = 200"},
      {"model = 'equidistant'\nfocal_px = 9\ncentre_px = [1, 2]\nfov_deg = 180\ncircle_px = [1, 2, 3]", "not both"},
      {"model = 'equisolid'\nfov_deg = 180\ncircle_px = [1, 2, -3]", "a radius >= 1"},
      {"model = 'equisolid'\nfov_deg = 180", "circle_px is missing"},
      {"model = 'opencv_fisheye'\nfocal_px = [9, 9]\ncentre_px = [1, 2]\nk = [1, 2]", "k = [ 1, 2 ]: expected a list"},
      {"model = 'scaramuzza'\npolynomial = [150, 0, 1e-3]\ncentre_px = [1, 2]", "a0 < 0"},
      {"model = 'scaramuzza'\npolynomial = [-150]\ncentre_px = [1, 2]", "2 to 20 coefficients"},
      {"model = 'scaramuzza'\npolynomial = [-150, 0]\ncentre_px = [1, 2]\naffine = [1, 1, 1]", "c - d e > 0"},
      {"model = 'scaramuzza'\nocamcalib = 'missing.txt'", "ocamcalib = 'missing.txt': expected an existing file"},
      {"model = 'pinhole'\nfocal_px = [9, 9]\ncentre_px = [1, 2]\ndistortion = [1, 2, 3]", "k1, k2, p1, p2, k3"},
      {"model = 'pinhole'\nfocal_px = 9\ncentre_px = [1, 2]", "focal_px = 9: expected a list of 2 numbers"},
      {"model = 'pinhole'\nfocal_px = [9, 9]\ncentre_px = [1, 2]\nlargest_angle_deg = 30", "unknown key"}};
  for (const auto& [text, part] : cases) {
    const auto [lens, problems] = read(text);
    EXPECT_THAT(problems, HasSubstr(part)) << text;
    ASSERT_TRUE(lens) << text;
    EXPECT_TRUE(lens->project({0.0, 0.0, 1.0})) << text;
  }
}

TEST(ReadLens, OfAModelThatDoesNotExistNothingElseIsAsked) {
  const auto problems =
      read("model = 'pinhola'\nfocal_px = [9, 9]\ncentre_px = [1, 2]\ndistortion = [0, 0, 0, 0]").problems;
  EXPECT_THAT(problems, HasSubstr("model = 'pinhola'"));
  EXPECT_EQ(problems.find('\n'), std::string::npos) << problems;
}

}  // namespace
}  // namespace kasumi
