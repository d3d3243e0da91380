#include "tests/estimator/turbidity/sky_population.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/aerosol.hpp"
#include "base/statistics.hpp"
#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "fixtures/light/clouds.hpp"
#include "fixtures/noise/noise.hpp"
#include "tests/estimator/turbidity/sky_photographs.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi::test {
namespace {

using fixtures::fractal_noise;
using fixtures::ridged_noise;
using fixtures::smooth_step;

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1.0p-53;
  }
  // As likely in each octave.
  double about(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  std::uint64_t seed() { return random_() >> 16; }

 private:
  std::mt19937_64 random_;
};

Direction sun_at(Dice& dice) {
  const double zenith_deg = dice.between(20.0, 78.0);
  return direction_from(from_degrees(zenith_deg), from_degrees(dice.between(0.0, 360.0)));
}

// A plane above the camera, in units of its height; the horizon is not infinitely far, for the earth is round.
glm::dvec2 on_layer(const Direction& d) {
  return glm::dvec2(d) / (d.z + 0.08);
}

using Texture = std::function<double(const glm::dvec2&)>;  // about -1 .. 1

Texture texture_of(Population population, Dice& dice) {
  const std::uint64_t seed = dice.seed();
  const double scale = dice.about(0.4, 8.0), turn = dice.between(0.0, kPi);
  const glm::dvec2 along{std::cos(turn), std::sin(turn)}, across{-along.y, along.x};
  if (population == Population::development) {
    const double stretch = dice.between(0.0, 1.0) < 0.3 ? dice.between(2.0, 6.0) : 1.0;
    const int octaves = 2 + static_cast<int>(dice.between(0.0, 4.0));
    return [=](const glm::dvec2& p) {
      return 1.6 * fractal_noise(seed, scale * glm::dvec2{glm::dot(p, along) / stretch, glm::dot(p, across)}, octaves);
    };
  }
  const double gain = dice.between(0.4, 0.65), warp = dice.between(0.0, 0.8);
  const bool ridged = dice.between(0.0, 1.0) < 0.5;
  return [=](const glm::dvec2& p) {
    const glm::dvec2 q = scale * p, w{fractal_noise(seed + 50, q, 2), fractal_noise(seed + 90, q, 2)};
    return ridged ? 2.2 * ridged_noise(seed, 0.7 * q + warp * w, 4, gain) - 1.4
                  : 1.6 * fractal_noise(seed, q + warp * w, 6, gain);
  };
}

// Clouds are white to bluish grey.
glm::dvec3 cloud_colour(Dice& dice) {
  const double blue = dice.between(-0.02, 0.10);
  return {1.0 - blue, 1.0, 1.0 + 1.2 * blue};
}

double henyey_greenstein(double cosine, double g) {
  return (1.0 - g * g) / std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5);
}

PopulationSky overcast(Population population, Dice& dice, int kind) {
  PopulationSky sky;
  sky.cover = Cover::overcast;
  sky.cloud_share = 1.0;
  sky.sun = sun_at(dice);
  const glm::dvec3 colour = cloud_colour(dice), low_colour = cloud_colour(dice);
  const Texture large = texture_of(population, dice), small = texture_of(population, dice);
  const double uneven = dice.about(0.03, 0.5), fine = dice.about(0.01, 0.2);
  const double gradation = dice.between(0.0, 2.5);  // 2: the CIE's overcast sky
  const Direction sun = sky.sun;
  const auto grey = [=](const Direction& d, double log_relief, double glow) {
    const double level = (1.0 + gradation * d.z) / (1.0 + gradation) * std::exp(log_relief) + glow;
    return level * glm::mix(low_colour, colour, std::sqrt(std::max(0.0, d.z)));
  };
  switch (kind) {
    case 0:
      sky.kind = "overcast";
      sky.light = [=](const Direction& d) {
        const glm::dvec2 p = on_layer(d);
        return grey(d, uneven * large(p) + fine * small(p), 0.0);
      };
      break;
    case 1: {
      sky.kind = "stratus, sun veiled";
      const double glow = dice.about(0.3, 6.0), width = dice.between(0.12, 0.6);
      sky.light = [=](const Direction& d) {
        const glm::dvec2 p = on_layer(d);
        return grey(d, 0.5 * uneven * large(p) + fine * small(p),
                    glow * std::exp(-angle_between(d, sun).value / width));
      };
      break;
    }
    case 2: {
      sky.kind = "stratocumulus rolls";
      const double waves = dice.between(3.0, 12.0), turn = dice.between(0.0, kPi), depth = dice.between(0.1, 0.5);
      const double glow = dice.between(0.0, 1.5);
      sky.light = [=](const Direction& d) {
        const glm::dvec2 p = on_layer(d);
        const double phase = waves * (p.x * std::cos(turn) + p.y * std::sin(turn)) + 2.0 * large(p);
        return grey(d, depth * std::sin(phase) + fine * small(p), glow * std::exp(-angle_between(d, sun).value / 0.3));
      };
      break;
    }
    case 3: {
      // Ice or altostratus through which the sun's place shows; blue hardly does.
      sky.kind = "thick veil";
      const double depth = dice.between(2.5, 9.0), g = dice.between(0.6, 0.85), blue = dice.between(0.3, 1.0);
      const double rough = dice.between(0.02, 0.3);
      sky.light = [=](const Direction& d) {
        const double tau = depth * std::exp(rough * large(on_layer(d))), slant = tau / (d.z + 0.15);
        const double once = henyey_greenstein(glm::dot(d, sun), g) * tau * std::exp(-tau);
        const double often = (1.0 - std::exp(-0.3 * slant)) * (1.0 + gradation * d.z) / (1.0 + gradation);
        return (1.5 * once + 4.0 * often) * colour +
               std::exp(-0.5 * slant) * blue * glm::dvec3{0.25, 0.45, 1.0} / (d.z + 0.4);
      };
      sky.beam = glm::dvec3{20.0 * std::exp(-depth / sun.z)};
      break;
    }
    case 4: {
      // Lumpy, with dark bases, brighter where it is thin and towards the sun.
      sky.kind = "stratocumulus";
      const double depth = dice.between(0.3, 1.0), glow = dice.between(0.0, 3.0), width = dice.between(0.2, 0.8);
      sky.light = [=](const Direction& d) {
        const glm::dvec2 p = on_layer(d);
        const double thin = std::clamp(0.5 + 0.5 * large(p), 0.0, 1.0);
        return (1.0 + glow * thin * std::exp(-angle_between(d, sun).value / width)) *
               grey(d, depth * (thin - 0.5) + fine * small(p), 0.0);
      };
      break;
    }
    default: {
      sky.kind = "fog";
      const double b = dice.between(-0.4, 0.8), glow = dice.between(0.0, 0.8), width = dice.between(0.3, 0.8);
      sky.light = [=](const Direction& d) {
        return (1.0 + b * d.z + glow * std::exp(-angle_between(d, sun).value / width)) * colour *
               std::exp(0.1 * fine * large(on_layer(d)));
      };
      break;
    }
  }
  return sky;
}

PopulationSky preetham_sky(Dice& dice) {
  PopulationSky sky;
  sky.kind = "Preetham's";
  sky.sun = sun_at(dice);
  const double turbidity = dice.between(2.0, 5.0);
  const Direction sun = sky.sun;
  sky.light = [=](const Direction& d) {
    const glm::dvec3 v =
        preetham_yxy(turbidity, zenith_angle(d).value, zenith_angle(sun).value, angle_between(d, sun).value);
    return glm::max(xyz_to_linear_srgb() * glm::dvec3{v.x * v.y / v.z, v.x, v.x * (1 - v.y - v.z) / v.z},
                    glm::dvec3{1e-3 * v.x});
  };
  sky.beam = 25.0 * sky.light({0.0, 0.0, 1.0});
  sky.aod_550 = aerosol_of(turbidity).aod_550;
  return sky;
}

PopulationSky spectral_sky(Population population, Dice& dice) {
  const std::vector<AerosolKind> kinds =
      population == Population::development
          ? std::vector{AerosolKind::continental, AerosolKind::urban, AerosolKind::maritime, AerosolKind::dust}
          : std::vector{AerosolKind::continental, AerosolKind::polluted, AerosolKind::desert, AerosolKind::smoke};
  PopulationSky sky;
  sky.sun = sun_at(dice);
  reference::Air air;
  const AerosolKind kind =
      kinds[static_cast<std::size_t>(dice.between(0.0, 0.999) * static_cast<double>(kinds.size()))];
  air.aerosol = {dice.about(0.03, 0.6), natural_exponent(kind), kind};
  const reference::ReferenceSky reference(air, 20.0, reference::suns_around_deg(to_degrees(zenith_angle(sky.sun))));
  const CloudlessSky simulated = simulated_sky(reference, kPopulationAltitude_m, sky.sun);
  sky.kind = fmt::format("spectral, {}", name_of(kind));
  sky.aod_550 = air.aerosol.aod_550;
  sky.light = simulated.light;
  sky.beam = simulated.sun_irradiance;
  return sky;
}

double white_under(const PopulationSky& sky) {  // luminance of a white sheet
  double falls = std::max(0.05, sky.sun.z) * sky.beam.y;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      falls +=
          kPi / 144.0 * sky.light(direction_from({std::acos(std::sqrt((i + 0.5) / 12.0))}, {(j + 0.5) * kPi / 6.0})).y;
  return falls / kPi;
}

PopulationSky broken(Population population, Dice& dice, const PopulationSky& behind) {
  PopulationSky sky = behind;
  sky.cover = Cover::broken;
  sky.kind = "broken before " + behind.kind;
  sky.cloud_share = dice.between(0.25, 0.97);
  const glm::dvec3 colour = cloud_colour(dice);
  const double base = dice.between(0.2, 0.8), bright = dice.between(0.8, 1.2), white = white_under(behind);
  const double most = dice.between(0.0, 1.0) < 0.25 ? dice.between(0.5, 0.9) : 1.0;  // of opacity: cirrus
  const Direction sun = behind.sun;
  const auto behind_light = behind.light;
  const auto lit = [=](const glm::dvec3& clear, double opacity, double thick, double relief, const Direction& d) {
    const double lining = 1.0 + 1.5 * std::exp(-angle_between(d, sun).value / 0.2) * (1.0 - thick);
    const glm::dvec3 cloud = std::lerp(bright, base, thick) * (1.0 + 0.2 * relief) * lining * white * colour;
    return glm::mix(clear, cloud, most * opacity);
  };
  if (population == Population::held_out && dice.between(0.0, 1.0) < 0.4) {
    const auto layer = std::make_shared<fixtures::CloudLayer>(dice.seed() >> 20, sky.cloud_share, 0.0, sun);
    sky.light = [=](const Direction& d) {
      const fixtures::CloudSample at = layer->at(d, 0.01);
      return lit(behind_light(d), at.opacity, at.thickness, at.relief, d);
    };
    sky.beam *= layer->sunlight_at({0.0, 0.0, 0.0});
    return sky;
  }
  const Texture texture = texture_of(population, dice);
  const double soft = dice.about(0.03, 0.25);
  std::vector<double> heights;
  for (int i = 0; i < 4000; ++i)
    heights.push_back(
        texture(on_layer(direction_from({std::acos(0.208 + 0.792 * (i + 0.5) / 4000.0)}, {2.399963 * i}))));
  const double level = quantile_in_place(heights, 1.0 - sky.cloud_share);
  sky.light = [=](const Direction& d) {
    const double inside = texture(on_layer(d)) - level;
    const double opacity = smooth_step(-soft, soft, inside);
    return opacity <= 0.0 ? behind_light(d) : lit(behind_light(d), opacity, smooth_step(0.0, 0.6, inside), inside, d);
  };
  sky.beam *= 1.0 - most * smooth_step(-soft, soft, texture(on_layer(sun)) - level);
  return sky;
}

}  // namespace

std::vector<PopulationSky> overcast_skies(Population population, int count) {
  Dice dice(population == Population::development ? 11 : 12);
  std::vector<PopulationSky> skies;
  for (int i = 0; i < count; ++i) skies.push_back(overcast(population, dice, i % 6));
  return skies;
}

std::vector<PopulationSky> cloudless_skies(Population population, int count, const std::string& folder) {
  Dice dice(population == Population::development ? 21 : 22);
  std::vector<PopulationSky> skies;
  for (int i = 0; i < count; ++i) skies.push_back(i % 5 == 4 ? preetham_sky(dice) : spectral_sky(population, dice));
  if (population == Population::development) return skies;
  for (CloudlessSky& measured : measured_skies(folder)) {
    PopulationSky sky;
    sky.kind = "measured, " + measured.name;
    sky.sun = measured.sun;
    sky.light = measured.light;
    sky.beam = measured.sun_irradiance;
    skies.push_back(std::move(sky));
  }
  return skies;
}

std::vector<PopulationSky> broken_skies(Population population, int count, const std::vector<PopulationSky>& cloudless) {
  Dice dice(population == Population::development ? 31 : 32);
  std::vector<PopulationSky> skies;
  for (int i = 0; i < count; ++i)
    skies.push_back(broken(population, dice, cloudless[static_cast<std::size_t>(i) % cloudless.size()]));
  return skies;
}

}  // namespace kasumi::test
