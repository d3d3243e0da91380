// The example configuration is what operators read: it must be valid, contain every key, and state the true defaults.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <tuple>

#include "pipeline/site/config/run_config.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::string example() {
  return read_text_file(source_folder() / "systemd/kasumi.toml").value();
}

// Read in a folder with the files it refers to.
struct Read {
  Result<> whole;
  RunConfig config;
  std::set<std::string> keys;
};
Read read(const std::string& text) {
  const auto folder = operating_folder("example");
  const std::filesystem::path demo = source_folder() / "fixtures/demo";
  std::filesystem::create_directory_symlink(demo, folder / "clear-noon");
  std::filesystem::copy_file(demo.parent_path() / "temple.glb", folder / "temple.glb");
  // Masks of the example's picture sizes that hide nothing, as P5: the format is recognised by its first bytes.
  for (const auto& [name, width, height] : {std::tuple{"sky-mask.png", 480, 480}, {"scene-mask.png", 960, 540}}) {
    std::ofstream mask(folder / name, std::ios::binary);
    mask << "P5\n"
         << width << " " << height << "\n255\n"
         << std::string(static_cast<std::size_t>(width) * height, '\xff');
  }
  std::ofstream(folder / "still-summer.png") << "only its name is read";
  const auto root = ConfigTable::parse(text, folder / "kasumi.toml").value();
  auto config = read_run_config(root);
  auto whole = root.finish();
  return {whole, std::move(config), root.keys_asked()};
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

// Keys in the file, active or commented out, such as "sky.camera.buffers".
std::set<std::string> documented(const std::string& text) {
  static const std::regex section(R"(^(?:# )?\[([a-z_.]+)\].*)"), key(R"(^#? ?([a-z0-9_]+) = .*)");
  std::set<std::string> found;
  std::string table;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, section))
      table = match[1];
    else if (std::regex_match(line, match, key))
      found.insert(table.empty() ? match[1].str() : table + "." + match[1].str());
  }
  return found;
}

TEST(ExampleConfiguration, IsAcceptedAsItIs) {
  const auto given = read(example());
  EXPECT_TRUE(given.whole) << given.whole.error().message;
}

TEST(ExampleConfiguration, ItsDefaultsAreTheDefaults) {
  const auto as_it_is = read(example());
  const auto text = std::regex_replace(example(), std::regex(R"((^|\n)#([a-z0-9_]+ = ))"), "$1$2");
  ASSERT_NE(text, example());
  const auto spelled_out = read(text);
  ASSERT_TRUE(spelled_out.whole) << spelled_out.whole.error().message;
  const auto& a = as_it_is.config;
  const auto& b = spelled_out.config;
  EXPECT_EQ(a.sky_camera, b.sky_camera);
  EXPECT_EQ(a.scene_camera, b.scene_camera);
  EXPECT_EQ(a.display, b.display);
  EXPECT_EQ(a.overlay, b.overlay);
  EXPECT_EQ(a.planes, b.planes);
  EXPECT_EQ(a.still.caption, b.still.caption);
  EXPECT_EQ(a.messages.language, b.messages.language);
  EXPECT_EQ(a.messages.show_faults, b.messages.show_faults);
  EXPECT_EQ(a.clock.policy, b.clock.policy);
  EXPECT_EQ(a.clock.earliest, b.clock.earliest);
  EXPECT_EQ(a.opening, b.opening);
  EXPECT_EQ(a.wake_before, b.wake_before);
  EXPECT_EQ(a.cec, b.cec);
  EXPECT_EQ(a.ladder, b.ladder);
  const auto &sky = a.installation.sky, &other = b.installation.sky;
  EXPECT_EQ(sky.colour_space, other.colour_space);
  EXPECT_EQ(sky.white_balance, other.white_balance);
  EXPECT_EQ(sky.yuv_encoding, other.yuv_encoding);
  for (const glm::dvec2 pixel : {glm::dvec2(241.0, 238.0), glm::dvec2(100.0, 200.0), glm::dvec2(12.0, 238.0)})
    EXPECT_EQ(sky.direction_at(pixel), other.direction_at(pixel));
  EXPECT_EQ(a.installation.scene.direction_at({5.0, 7.0}), b.installation.scene.direction_at({5.0, 7.0}));
  EXPECT_EQ(a.installation.scene_quality.point_spread_px, b.installation.scene_quality.point_spread_px);
  EXPECT_EQ(a.installation.scene_quality.shared_chroma, b.installation.scene_quality.shared_chroma);
  EXPECT_EQ(a.installation.scene_quality.sharpening, b.installation.scene_quality.sharpening);
  EXPECT_EQ(a.installation.scene_quality.jpeg_blocks, b.installation.scene_quality.jpeg_blocks);
  EXPECT_EQ(a.installation.object.placement.heading, b.installation.object.placement.heading);
  EXPECT_EQ(a.installation.object.placement.scale, b.installation.object.placement.scale);
  EXPECT_EQ(a.installation.surroundings.ground_albedo, b.installation.surroundings.ground_albedo);
  EXPECT_EQ(a.installation.surroundings.fog.extinction_per_m, 0.0);
  EXPECT_EQ(a.installation.surroundings.cloud_base_m, b.installation.surroundings.cloud_base_m);
  EXPECT_EQ(a.installation.surroundings.air, b.installation.surroundings.air);
}

TEST(ExampleConfiguration, EveryKeyThatIsReadIsInIt) {
  const auto text = example();
  const auto known = documented(text);
  // Keys of other lenses and alternative notations are described in comments and in docs/cameras.md.
  const std::set<std::string> text_of{"sky.heading_deg",      "sky.pitch_deg",
                                      "sky.roll_deg",         "sky.response_table",
                                      "scene.azimuth_up_deg", "scene.response_table",
                                      "object.latitude_deg",  "object.longitude_deg",
                                      "object.altitude_m",    "sky.lens.fov_deg",
                                      "sky.lens.circle_px",   "sky.measured",
                                      "scene.measured",       "scene.depth_inverse_offset"};
  const auto scene_device = text.find("[scene.camera]");
  auto replay = text;
  replay =
      replaced(replay, "source = \"v4l2\"                     #", "source = \"replay\"\nfixture = \"clear-noon\"  #");
  replay = replaced(replay, "device = \"/dev/v4l/by-id/usb-Example_Sky_Camera_0001-video-index0\"", "");
  auto libcamera = text;
  libcamera =
      libcamera.substr(0, scene_device) +
      replaced(replaced(libcamera.substr(scene_device), "source = \"v4l2\"", "source = \"libcamera\"\ncamera = \"x\""),
               "device = \"/dev/v4l/by-id/usb-Example_Scene_Camera_0002-video-index0\"", "");
  const auto window = replaced(text, "#kind = \"kms\"", "kind = \"window\"");
  const auto headless = replaced(text, "#kind = \"kms\"", "kind = \"headless\"");
  auto foggy = text;
  for (const char* line : {"[site.fog]", "extinction_per_m", "base_altitude_m", "scale_height_m"})
    foggy = replaced(foggy, std::string("# ") + line, line);
  EXPECT_EQ(read(foggy).config.installation.surroundings.fog, (FogLayer{0.002, 941.0, 30.0}));
  std::set<std::string> missing;
  for (const auto& variant : {text, replay, libcamera, window, headless, foggy}) {
    const auto given = read(variant);
    EXPECT_TRUE(given.whole) << given.whole.error().message;
    for (const auto& key : given.keys) {
      const bool table = text.find("[" + key + "]") != std::string::npos;
      // A key shown in one camera's table counts for the other's as well.
      auto twin = key;
      if (key.starts_with("scene.")) twin = "sky." + key.substr(6);
      if (!table && !known.contains(key) && !known.contains(twin) && !text_of.contains(key)) missing.insert(key);
    }
  }
  EXPECT_THAT(missing, testing::IsEmpty());
  EXPECT_GT(known.size(), 60u);
}

TEST(ExampleConfiguration, ItsErasAreAccepted) {
  auto text = example();
  const auto begin = text.find("# [[era]]"), end = text.find("\n\n", begin);
  ASSERT_NE(begin, std::string::npos);
  const auto eras = std::regex_replace(text.substr(begin, end - begin), std::regex("(^|\n)# "), "$1");
  text = text.replace(begin, end - begin, eras + "\n[[era]]\nname = \"rest\"\n");
  const auto given = read(text);
  EXPECT_TRUE(given.whole) << given.whole.error().message;
  ASSERT_EQ(given.config.eras.size(), 2u);
  const auto& summer = given.config.eras.front();
  EXPECT_TRUE(summer.model && summer.scene && summer.picture && summer.caption && !summer.otherwise);
  for (const auto& key : given.keys)
    if (key.starts_with("era[0].") || key.starts_with("era[1].")) {
      EXPECT_NE(text.find("\n" + key.substr(7) + " = "), std::string::npos) << key;
    }
}

TEST(ExampleConfiguration, AMissingKeyWouldBeFound) {
  const auto known =
      documented("[sky.camera]\n#buffers = 4\n# gain = 1.0\nsource = \"v4l2\"\n# words about format = x y\n");
  EXPECT_THAT(known, testing::UnorderedElementsAre("sky.camera.buffers", "sky.camera.gain", "sky.camera.source"));
}

}  // namespace
}  // namespace kasumi
