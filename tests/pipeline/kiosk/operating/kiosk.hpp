// A small kiosk for tests: two recorded cameras of 20 pictures a second and a configuration that plays them.
#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>

#include "base/files.hpp"
#include "capture/fixture/fixture_writer.hpp"
#include "capture/fixture/replay_source.hpp"
#include "tests/places.hpp"

namespace kasumi {

inline std::filesystem::path operating_folder(const std::string& name) {
  auto path = test_output_folder() / "operating" / name;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

constexpr int kKioskWidth = 64, kKioskHeight = 48;
constexpr std::size_t kKioskBytes = 3u * kKioskWidth * kKioskHeight;  // of one picture, RGB3

inline Frame kiosk_frame(int number, std::uint8_t level) {
  Frame frame;
  auto& metadata = frame.metadata;
  metadata.captured_at = Instant(std::chrono::seconds(100) + number * std::chrono::milliseconds(50));
  metadata.utc = Utc(std::chrono::sys_days{std::chrono::year{2026} / 6 / 21}) + std::chrono::hours(3) +
                 number * std::chrono::milliseconds(50);
  metadata.sequence = static_cast<std::uint32_t>(number);
  metadata.format = four_cc("RGB3");
  metadata.width = kKioskWidth;
  metadata.height = kKioskHeight;
  metadata.stride = 3 * kKioskWidth;
  metadata.bytes_used = kKioskBytes;
  metadata.exposure_s = 0.004;
  std::vector<std::uint8_t> pixels(kKioskBytes);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = static_cast<std::uint8_t>(level / 2 + (i * 31 + static_cast<std::size_t>(number) * 17) % 64);
  frame.payload = payload_of(std::move(pixels));
  return frame;
}

// One camera's recording: 60 pictures, and where `gone_at` says an outage of a second.
inline void write_camera(const std::filesystem::path& folder, std::uint8_t level, int gone_at = -1) {
  auto writer = FixtureWriter::create(folder).value();
  int shift = 0;
  for (int number = 0; number < 60; ++number) {
    if (number == gone_at) {
      const auto before = kiosk_frame(number + shift, level).metadata;
      ASSERT_TRUE(writer.append_disconnect(before.captured_at, before.utc));
      shift = 20;
    }
    ASSERT_TRUE(writer.append(kiosk_frame(number + shift, level)));
  }
}

// Folder of the kiosk's configuration; `live` holds the cameras' recordings.
inline std::filesystem::path write_kiosk(const std::filesystem::path& folder, int scene_gone_at = -1) {
  write_camera(folder / "live" / "sky", 90);
  write_camera(folder / "live" / "scene", 200, scene_gone_at);
  std::filesystem::copy_file(source_folder() / "fixtures/temple.glb", folder / "temple.glb");
  // A P5 of the right size: half of the sky is hidden by a roof.
  std::ofstream mask(folder / "roof mask.pgm", std::ios::binary);
  mask << "P5\n" << kKioskWidth << " " << kKioskHeight << "\n255\n";
  for (int i = 0; i < kKioskWidth * kKioskHeight; ++i) mask << static_cast<char>(i % 2 ? 255 : 0);
  mask.close();
  const auto config = folder / "kasumi.toml";
  std::ofstream(config) << R"(
[site]
latitude_deg = 34.21
longitude_deg = 135.59
altitude_m = 980.0
[sky]
width = 64
height = 48
azimuth_up_deg = 18.0
response = "srgb"
mask = "roof mask.pgm"
[sky.lens]
model = "equidistant"
focal_px = 14.76487326843647
centre_px = [31.5, 23.5]
[sky.camera]
source = "replay"
fixture = "live"
[scene]
width = 64
height = 48
heading_deg = 4.0
pitch_deg = 0.5
response = "srgb"
[scene.lens]
model = "pinhole"
focal_px = [600.0, 600.0]
centre_px = [31.5, 23.5]
[scene.camera]
source = "replay"
fixture = "live"
[object]
model = "temple.glb"
east_m = 306.0
north_m = 3487.15
up_m = -39.0
[display]
kind = "headless"
width = 320
height = 240
)";
  return config;
}

}  // namespace kasumi
