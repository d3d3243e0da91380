// Land in haze by Koschmieder's law in closed form: nothing of the program's own air is in it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "base/photograph.hpp"

namespace kasumi {

constexpr int kLandWidth = 640, kLandHeight = 480, kLandHorizon = 160;
// Of a camera with three narrow channels, whose extinction is that of one wavelength each.
inline const glm::dvec3 kLandWavelengths_nm{610.0, 550.0, 460.0};

// Reflectance of what land is made of: wood, grass, soil, brick, concrete, slate, sand, white walls.
inline constexpr std::array<glm::dvec3, 8> kLandMaterials{{{0.04, 0.06, 0.03},
                                                           {0.08, 0.13, 0.05},
                                                           {0.20, 0.15, 0.10},
                                                           {0.30, 0.12, 0.08},
                                                           {0.32, 0.31, 0.29},
                                                           {0.12, 0.12, 0.13},
                                                           {0.42, 0.36, 0.27},
                                                           {0.75, 0.74, 0.70}}};

struct HazyLand {
  double exponent = 0.0;
  double green_per_km = 1.0;
  double nearest_m = 300.0, farthest_m = 3000.0;
  glm::dvec3 infinity{0.62, 0.62, 0.60};
  double noise = 1.0 / 255.0;
  unsigned seed = 1;
  // The near half of one material, the far of another; else all mixed.
  bool land_changes = false;
};

// Level ground: one over the distance is even in rows.
inline double distance_of_row(const HazyLand& land, int y) {
  const double down = static_cast<double>(y - kLandHorizon) / (kLandHeight - 1 - kLandHorizon);
  return 1.0 / std::lerp(1.0 / land.farthest_m, 1.0 / land.nearest_m, down);
}

inline double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

// Level land up to row 160, of patches of all materials in light and shade; sky above. Eight bits, with noise.
inline Photograph drawn(const HazyLand& land) {
  std::mt19937 random(land.seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, land.noise);
  constexpr int kPatch = 5;
  std::vector<glm::dvec3> patches;
  const int across = kLandWidth / kPatch;
  for (int i = 0; i < across * (kLandHeight / kPatch); ++i) {
    auto at = static_cast<std::size_t>(8.0 * share(random));
    if (land.land_changes) at = i / across < (kLandHorizon + 160) / kPatch ? 7 : 3;
    // In the sun or in its own shade: the sky's brightness is that of a white surface under half of the sky.
    const double light = share(random) < 0.4 ? 0.15 + 0.25 * share(random) : 0.6 + 0.8 * share(random);
    patches.push_back(light * kLandMaterials[at]);
  }
  Photograph photograph;
  photograph.quantum = 1.0 / 255.0;
  photograph.encoded = Image<glm::vec3>(kLandWidth, kLandHeight);
  const glm::dvec3 per_m = 1e-3 * land.green_per_km *
                           glm::dvec3(std::pow(kLandWavelengths_nm.r / 550.0, -land.exponent), 1.0,
                                      std::pow(kLandWavelengths_nm.b / 550.0, -land.exponent));
  for (int y = 0; y < kLandHeight; ++y)
    for (int x = 0; x < kLandWidth; ++x) {
      glm::dvec3 light = land.infinity;
      if (y >= kLandHorizon) {
        const double distance_m = distance_of_row(land, y);
        const auto rho = patches[static_cast<std::size_t>(y / kPatch * across + x / kPatch)];
        for (int c = 0; c < 3; ++c) {
          const double left = std::exp(-per_m[c] * distance_m);
          light[c] *= rho[c] * left + 1.0 - left;
        }
      }
      for (int c = 0; c < 3; ++c) {
        const double seen = std::clamp(srgb_of(light[c]) + noise(random), 0.0, 1.0);
        photograph.encoded.at(x, y)[c] = static_cast<float>(std::round(255.0 * seen) / 255.0);
      }
    }
  return photograph;
}

}  // namespace kasumi
