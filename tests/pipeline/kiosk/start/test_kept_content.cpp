// The content that worked last, kept for the day on which the configured one is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "base/files.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr Utc kNoon = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + std::chrono::hours(12);

// A kiosk whose calibration, mask, and model with a texture of its own lie in several folders.
struct KeptKiosk {
  explicit KeptKiosk(const std::string& name)
      : folder(operating_folder("kept-" + name)), config(write_kiosk(folder)), kept(folder / "state/last-good") {
    fs::create_directories(folder / "models");
    for (const char* file : {"BoxTextured.gltf", "BoxTextured0.bin", "CesiumLogoFlat.png"})
      if (fs::exists(fs::path("/usr/share/assimp/models/glTF2/BoxTextured-glTF") / file))
        fs::copy_file(fs::path("/usr/share/assimp/models/glTF2/BoxTextured-glTF") / file, folder / "models" / file);
    change("model = \"temple.glb\"", fmt::format("model = \"{}\"", (folder / "temple.glb").string()));
    change("[display]", "[state]\nfolder = \"state\"\n[display]");
  }
  void change(const std::string& from, const std::string& to) {
    auto text = read_text_file(config).value();
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    ASSERT_TRUE(write_text_file(config, text));
  }
  ContentPtr read() const {
    auto content = read_content(config);
    EXPECT_TRUE(content) << content.error().message;
    return content.value_or(nullptr);
  }
  fs::path folder, config, kept;
};

TEST(KeptContent, Row32WhatWorkedIsWholeAfterEveryFileWasSpoilt) {
  KeptKiosk kiosk("whole");
  const auto before = must(kiosk.read());
  const auto kept = must(keep_content(*before, kiosk.kept, kNoon));
  EXPECT_TRUE(is_kept(*before, kiosk.kept));
  for (const char* file : {"kasumi.toml", "temple.glb", "roof mask.pgm"})
    ASSERT_TRUE(write_text_file(kiosk.folder / file, "spoilt"));
  ASSERT_FALSE(read_content(kiosk.config));
  const auto after = must(read_kept_content(kiosk.config, kiosk.kept, {"kasumi.toml: not valid TOML"}));
  EXPECT_EQ((*after)->model->triangle_count(), before->model->triangle_count());
  EXPECT_EQ((*after)->config.installation.sky.mask.width(), kKioskWidth);
  EXPECT_EQ((*after)->config.state_folder, before->config.state_folder) << "folders stay where they are";
  EXPECT_EQ((*after)->config.scene_camera, before->config.scene_camera);
  ASSERT_TRUE((*after)->instead);
  EXPECT_EQ((*after)->instead->kept_utc, kNoon);
  EXPECT_THAT((*after)->instead->refused, ElementsAre(HasSubstr("not valid TOML")));
}

TEST(KeptContent, AnEditThatNobodyAppliedIsNotKept) {
  KeptKiosk kiosk("edited");
  const auto shown = must(kiosk.read());
  ASSERT_TRUE(keep_content(*shown, kiosk.kept, kNoon));
  std::ofstream(kiosk.config, std::ios::app) << "# a night's idea\n";
  const auto kept = keep_content(*shown, kiosk.kept, kNoon + std::chrono::hours(1));
  ASSERT_FALSE(kept);
  EXPECT_THAT(kept.error().message, HasSubstr("has changed since it was read"));
  EXPECT_EQ(read_kept_content(kiosk.config, kiosk.kept, {}).value()->instead->kept_utc, kNoon);
}

TEST(KeptContent, UnchangedContentIsNotWrittenAgain) {
  KeptKiosk kiosk("again");
  const auto shown = must(kiosk.read());
  ASSERT_TRUE(keep_content(*shown, kiosk.kept, kNoon));
  ASSERT_TRUE(keep_content(*kiosk.read(), kiosk.kept, kNoon + std::chrono::hours(1)));
  EXPECT_EQ(read_kept_content(kiosk.config, kiosk.kept, {}).value()->instead->kept_utc, kNoon);
}

// A power cut at any moment leaves the old copies or the new ones: whatever is half written is not named yet.
TEST(KeptContent, ACutWhileKeepingLeavesTheOldContent) {
  KeptKiosk kiosk("cut");
  ASSERT_TRUE(keep_content(*kiosk.read(), kiosk.kept, kNoon));
  fs::create_directories(kiosk.kept / "b");
  ASSERT_TRUE(write_text_file(kiosk.kept / "b" / "half", "a file"));
  EXPECT_TRUE(read_kept_content(kiosk.config, kiosk.kept, {}));
  kiosk.change("altitude_m = 980.0", "altitude_m = 981.0");
  ASSERT_TRUE(keep_content(*kiosk.read(), kiosk.kept, kNoon + std::chrono::hours(1)));
  EXPECT_FALSE(fs::exists(kiosk.kept / "b" / "half"));
  const auto now = read_kept_content(kiosk.config, kiosk.kept, {}).value();
  EXPECT_DOUBLE_EQ(now->config.installation.site.altitude_m, 981.0);
}

// What the disk did to the newer copies, the older ones do not have: every file of them, every way.
TEST(KeptContent, Row41WhereTheNewestIsDamagedTheOneBeforeItServes) {
  KeptKiosk kiosk("damaged");
  ASSERT_TRUE(keep_content(*kiosk.read(), kiosk.kept, kNoon));
  kiosk.change("altitude_m = 980.0", "altitude_m = 981.0");
  ASSERT_TRUE(keep_content(*kiosk.read(), kiosk.kept, kNoon + std::chrono::hours(1)));
  const auto altitude = [&] {
    const auto kept = read_kept_content(kiosk.config, kiosk.kept, {});
    return kept ? (*kept)->config.installation.site.altitude_m : 0.0;
  };
  EXPECT_DOUBLE_EQ(altitude(), 981.0);
  std::vector<fs::path> files{kiosk.kept / "kept.json"};
  for (const auto& entry : fs::recursive_directory_iterator(kiosk.kept / "b"))
    if (entry.is_regular_file()) files.push_back(entry.path());
  ASSERT_GE(files.size(), 4u);
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const auto good = read_file(file).value();
    auto flipped = good;
    flipped[flipped.size() / 2] ^= 1;
    ASSERT_TRUE(write_file(file, flipped));
    EXPECT_DOUBLE_EQ(altitude(), 980.0) << "one bit";
    ASSERT_TRUE(write_text_file(file, ""));
    EXPECT_DOUBLE_EQ(altitude(), 980.0) << "empty";
    fs::remove(file);
    EXPECT_DOUBLE_EQ(altitude(), 980.0) << "gone";
    ASSERT_TRUE(write_file(file, good));
  }
  EXPECT_DOUBLE_EQ(altitude(), 981.0);
}

TEST(KeptContent, AModelsOwnFilesAreKeptWithIt) {
  KeptKiosk kiosk("gltf");
  if (!fs::exists(kiosk.folder / "models/BoxTextured.gltf")) GTEST_SKIP() << "assimp-testmodels are not installed";
  kiosk.change(fmt::format("\"{}\"", (kiosk.folder / "temple.glb").string()), "\"models/BoxTextured.gltf\"");
  const auto before = must(kiosk.read());
  ASSERT_EQ(before->model->textures.size(), 1u);
  const auto kept = keep_content(*before, kiosk.kept, kNoon);
  ASSERT_TRUE(kept) << kept.error().message;
  fs::remove_all(kiosk.folder / "models");
  const auto after = must(read_kept_content(kiosk.config, kiosk.kept, {}));
  EXPECT_EQ((*after)->model->textures.size(), 1u);
}

TEST(KeptContent, NothingKeptOrDamagedIsAFaultAndNotAPicture) {
  KeptKiosk kiosk("nothing");
  EXPECT_FALSE(read_kept_content(kiosk.config, kiosk.kept, {}));
  fs::create_directories(kiosk.kept);
  for (const char* text : {"", "[", "{}", "{\"folder\": \"../..\", \"utc\": \"2026-06-21T00:00:00Z\", \"files\": []}",
                           "{\"folder\": \"a\", \"utc\": \"2026-06-21T00:00:00Z\", \"files\": [{\"bytes\": \"x\"}]}"}) {
    ASSERT_TRUE(write_text_file(kiosk.kept / "kept.json", text));
    EXPECT_FALSE(read_kept_content(kiosk.config, kiosk.kept, {})) << text;
  }
}

}  // namespace
}  // namespace kasumi
