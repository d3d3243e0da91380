// Scenes of the physical world, drawn by the spectral atmosphere, in which the building is compared with the truth.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "tests/pipeline/recorded.hpp"

namespace kasumi {

constexpr Utc utc_of_2026(unsigned month, unsigned day, std::chrono::minutes time) {
  return Utc(std::chrono::sys_days(std::chrono::year{2026} / static_cast<int>(month) / static_cast<int>(day))) + time;
}
// At the presets' lookout.
constexpr Utc kSun62DegHigh = utc_of_2026(4, 22, std::chrono::minutes(4 * 60 + 11)),
              kSun31DegHigh = utc_of_2026(10, 20, std::chrono::minutes(5 * 60 + 24));

struct BuildingScene {
  std::string name;
  fixtures::Recipe recipe;
  double goal;  // of 255
  double held;  // what the error is held to, where the goal is not reached
};

// One picture of each camera.
inline fixtures::Recipe pictured(std::string_view preset, int sky_size) {
  auto recipe = small(preset, 1);
  recipe.sky_size = sky_size;
  recipe.truth_frames = 1;
  return recipe;
}

inline BuildingScene under(fixtures::Recipe recipe, double turbidity, Utc time, double goal, double held) {
  recipe.turbidity = recipe.turbidity_end = turbidity;
  recipe.start_utc = time;
  return {fmt::format("T {}, sun {} deg high", turbidity, time == kSun62DegHigh ? 62 : 31), recipe, goal, held};
}

}  // namespace kasumi
