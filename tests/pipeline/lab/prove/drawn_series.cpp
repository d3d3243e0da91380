#include "tests/pipeline/lab/prove/drawn_series.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/picture.hpp"
#include "calib/light/radiometry.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 480, kHeight = 200, kSkyline = 150, kMargin = 20, kDays = 8, kHours = 5;

struct DrawnTower {
  const char* name;
  double distance_m;
  int x, top, width;
  double own;  // L0 / Linf
};
constexpr std::array kTowers{
    DrawnTower{"mill", 900.0, 40, 110, 24, 0.08},    DrawnTower{"church", 1500.0, 100, 100, 20, 0.05},
    DrawnTower{"silo", 2100.0, 165, 95, 22, 0.07},   DrawnTower{"keep", 2600.0, 230, 90, 26, 0.06},
    DrawnTower{"works", 3400.0, 300, 105, 24, 0.05}, DrawnTower{"mast", 4600.0, 370, 100, 20, 0.06},
    DrawnTower{"abbey", 3000.0, 425, 90, 26, 0.06}};

// Repeats for ever, without any pattern that a lag of a few pixels would fit.
double scattered(int x, int y) {
  const auto h = static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
  const auto mixed = (h ^ (h >> 13)) * 1274126177U;
  return static_cast<double>((mixed ^ (mixed >> 16)) & 0xffffU) / 65535.0;
}

glm::dvec3 infinity_at(int y) {
  return glm::dvec3{0.45, 0.52, 0.62} * (1.0 - 0.15 * (kSkyline - y) / kSkyline);
}

glm::dvec3 through_air(const glm::dvec3& own, int y, const DrawnPicture& picture, double distance_m) {
  const auto infinity = infinity_at(std::min(y, kSkyline));
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c) {
    const double gamma = std::exp(-picture.per_m[c] * distance_m);
    light[c] = infinity[c] * (1.0 - gamma) + gamma * own[c] * infinity[c];
  }
  return light;
}

glm::dvec3 light_at(int x, int y, const DrawnPicture& picture) {
  for (const auto& tower : kTowers) {
    if (x < tower.x || x >= tower.x + tower.width || y < tower.top || y >= kSkyline) continue;
    const bool window = (x - tower.x) % 5 > 2 && (y - tower.top) % 7 > 3;
    const double own = tower.own + (window ? 0.05 : 0.0) + 0.02 * scattered(x, y);
    return through_air(glm::dvec3{1.1, 1.0, 0.8} * own, y, picture, tower.distance_m);
  }
  if (y < kSkyline) return infinity_at(y);
  // Roofs, the nearer the lower.
  const double roof = 0.1 + 0.6 * scattered(x / 7, y / 5);
  return through_air(glm::dvec3{1.2, 1.0, 0.8} * roof, y, picture,
                     120.0 + 600.0 * (kHeight - y) / (kHeight - kSkyline));
}

Image<Rgb8> drawn(const DrawnPicture& picture, int number) {
  Image<glm::dvec3> light(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      light.at(x, y) = light_at(x - picture.moved_px, y, picture);
      if (picture.night) light.at(x, y) *= 0.004;
    }
  const auto response = Response::srgb();
  Image<Rgb8> encoded(kWidth, kHeight);
  const int blur = picture.drops ? 3 : 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      glm::dvec3 sum{0.0};
      int count = 0;
      for (int j = std::max(0, y - blur); j <= std::min(kHeight - 1, y + blur); ++j)
        for (int i = std::max(0, x - blur); i <= std::min(kWidth - 1, x + blur); ++i, ++count) sum += light.at(i, j);
      const auto value = 255.0 * response.to_encoded(sum / static_cast<double>(count));
      const double noise = 2.0 * (scattered(x + 977 * number, y) - 0.5);
      for (int c = 0; c < 3; ++c)
        encoded.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(std::clamp(value[c] + noise, 0.0, 255.0)));
    }
  return encoded;
}

std::vector<DrawnPicture> planned() {
  std::vector<DrawnPicture> pictures;
  constexpr std::array kGreen_per_km{0.03, 0.05, 0.35, 0.04, 0.16, 0.07, 0.6, 0.05};
  for (int day = 0; day < kDays; ++day)
    for (int hour = 0; hour < kHours; ++hour) {
      const double green = kGreen_per_km[static_cast<std::size_t>(day)] * (1.0 + 0.12 * hour);
      DrawnPicture picture{fmt::format("2025{:02}{:02}_{:02}0000", 2, 3 + day, 9 + hour),
                           fmt::format("2025-02-{:02}T{:02}:00:00Z", 3 + day, 9 + hour),
                           1e-3 * green * glm::dvec3{0.8, 1.0, 1.3}};
      if (day == 5) picture.moved_px = 9;
      picture.drops = day == 3 && hour == 2;
      pictures.push_back(picture);
    }
  pictures.push_back({"20250203_220000", "2025-02-03T22:00:00Z", pictures.front().per_m, 0, true});
  return pictures;
}

}  // namespace

DrawnSeries draw_series(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  DrawnSeries series{folder, folder / "scenes.list", folder / "landmarks.toml", folder / "air.csv", planned()};
  std::string list, air = "utc,extinction_r_per_m,extinction_g_per_m,extinction_b_per_m\n", landmarks;
  int number = 0;
  for (const auto& picture : series.pictures) {
    const auto file = folder / (picture.name + ".png");
    EXPECT_TRUE(write_png(file, drawn(picture, ++number)));
    list += fmt::format("{}\t{}\t{}\n", file.string(), picture.utc, picture.per_m.g > 1e-4 ? "haze" : "clear");
    air += fmt::format("{},{},{},{}\n", picture.utc, picture.per_m.r, picture.per_m.g, picture.per_m.b);
  }
  for (const auto& tower : kTowers)
    landmarks += fmt::format(
        "[[landmarks]]\nname = \"{}\"\ndistance_m = {}\nregion_px = [{}, {}, {}, {}]\nsky_px = [{}, {}, 16, {}]\n",
        tower.name, tower.distance_m, tower.x + 2, tower.top + 4, tower.width - 4, kSkyline - tower.top - 8,
        tower.x - kMargin, tower.top, kSkyline - tower.top - 6);
  EXPECT_TRUE(write_text_file(series.list, list));
  EXPECT_TRUE(write_text_file(series.air, air));
  EXPECT_TRUE(write_text_file(series.landmarks, landmarks));
  return series;
}

}  // namespace kasumi
