// Readers of parts of a file: which keys they ignore, and which they still report as typing errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "calib/foreign_keys.hpp"
#include "pipeline/site/config/descriptions.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/config/run_config.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr const char* kCamera =
    "width = 60\nheight = 40\nresponse = \"srgb\"\nheading_deg = 0\npitch_deg = 0\n"
    "lens = {model = \"pinhole\", focal_px = [50.0, 50.0], centre_px = [29.5, 19.5]}\n";

// A kiosk's configuration with some keys for each reader.
std::string kiosk(const std::string& in_scene = "") {
  return "[site]\nlatitude_deg = 34.2\nlongitude_deg = 135.6\naltitude_m = 20\nfog = {top_m = 100}\n"
         "aerosol = \"dust\"\n"
         "[display]\nkind = \"headless\"\n[sky]\n" +
         std::string(kCamera) + "camera = {source = \"v4l2\", device = \"/dev/video0\"}\n[scene]\n" + kCamera +
         in_scene +
         "point_spread_px = 0.5\nnoise = {full_scale_electrons = 9000, read_electrons = 3}\n"
         "[[landmarks]]\nname = \"mast\"\nlatitude_deg = 34.3\nlongitude_deg = 135.6\naltitude_m = 90\n"
         "[[landmarks]]\nname = \"ridge\"\ndistance_m = 4000\nregion_px = [10, 10, 5, 5]\n";
}

std::filesystem::path written(const std::string& text) {
  const auto file = test_output_folder() / "kiosk.toml";
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(write_text_file(file, text));
  return file;
}

TEST(ForeignKeys, EveryPartialReaderAcceptsACompleteKioskConfiguration) {
  const auto file = written(kiosk("tone_exponent = 1.2\n"));
  const auto cameras = read_camera_file(file);
  EXPECT_TRUE(cameras) << cameras.error().message;
  const auto landmarks = read_landmark_file(file, 60, 40);
  ASSERT_TRUE(landmarks) << landmarks.error().message;
  EXPECT_EQ(landmarks->landmarks.size(), 1u) << "only one of them has a region";
}

TEST(ForeignKeys, ATypingErrorIsStillReported) {
  const auto file = written(kiosk("colour_spice = \"srgb\"\n") + "[dispaly]\nkind = \"kms\"\n");
  for (const auto& message :
       {read_camera_file(file).error().message, read_landmark_file(file, 60, 40).error().message}) {
    EXPECT_THAT(message, HasSubstr("scene.colour_spice: unknown key"));
    EXPECT_THAT(message, HasSubstr("dispaly: unknown key"));
  }
}

// Which other keys a camera or a display has depends on its kind, and a mask's size on the camera's.
TEST(ForeignKeys, OneWrongWordIsOneProblem) {
  const auto with = [](std::string text, const std::string& what, const std::string& by) {
    const auto at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return ConfigTable::parse(text.replace(at, what.size(), by), "a.toml").value();
  };
  const auto problems = [](const ConfigTable& root) {
    read_run_config(root);
    return root.finish().error().message;
  };
  EXPECT_THAT(problems(with(kiosk(), "kind = \"headless\"", "kind = \"head\"\nwidth = 9\nheight = 9")),
              testing::AllOf(HasSubstr("display.kind = 'head'"), testing::Not(HasSubstr("display.width")),
                             testing::Not(HasSubstr("display.height"))));
  EXPECT_THAT(problems(with(kiosk("camera = {source = \"v4l3\", device = \"/dev/video1\", gain = 2}\n"), "", "")),
              testing::AllOf(HasSubstr("scene.camera.source = 'v4l3'"), testing::Not(HasSubstr("scene.camera.device")),
                             testing::Not(HasSubstr("scene.camera.gain"))));
  EXPECT_THAT(problems(with(kiosk(), "camera = {source = \"v4l2\", device", "camera = {device")),
              testing::AllOf(HasSubstr("sky.camera.source is missing"), testing::Not(HasSubstr("sky.camera.device"))));
  EXPECT_THAT(problems(with(kiosk("mask = \"mask.png\"\n"), "[scene]\nwidth = 60", "[scene]\nwidth = \"60\"")),
              testing::AllOf(HasSubstr("scene.width = '60'"), testing::Not(HasSubstr("scene.mask"))));
}

// Otherwise a key added to the configuration would become a typing error elsewhere.
TEST(ForeignKeys, EveryKeyOfTheCompleteReadersIsKnown) {
  const auto complete = ConfigTable::parse(kiosk(), "a.toml").value();
  read_run_config(complete);
  read_fixture_info(complete);
  const auto known = ConfigTable::parse(kiosk(), "a.toml").value();
  read_site(known.table("site"));
  for (const char* camera : {"sky", "scene"}) read_camera(known.table(camera), camera);
  ignore_what_others_read(known, {"site", "sky", "scene"});
  const auto have = known.keys_asked();
  for (const auto& key : complete.keys_asked()) {
    const auto parts = std::count(key.begin(), key.end(), '.');
    const bool of_ours = key.starts_with("site.") || key.starts_with("sky.") || key.starts_with("scene.");
    if (parts == 0 || (parts == 1 && of_ours)) {
      EXPECT_TRUE(have.contains(key)) << key;
    }
  }
}

}  // namespace
}  // namespace kasumi
