// Where the sky camera looks and what it sees there, in a form that can be fitted.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "base/geometry.hpp"
#include "base/image.hpp"
#include "base/saturation.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SampleLimits {
  Radians least_sun_distance = from_degrees(10.0);
  Radians largest_zenith = from_degrees(80.0);
  double saturated = kSaturatedSky;  // encoded level from which a channel counts as saturated
  double dark_quanta = 2.5;          // a channel below this many quanta is too coarsely quantised
  double shot_noise = 0.005;         // relative standard deviation of light at full scale; grows with 1 / sqrt(light)
};

// One sky pixel.
struct LuminanceSample {
  float zenith = 0.0f;         // [rad]
  float sun_distance = 0.0f;   // gamma [rad]
  float log_luminance = 0.0f;  // ln Y, any unit: the gain is free
  float sigma = 0.0f;          // standard deviation of log_luminance, from quantisation and shot noise
  float quantisation = 0.0f;   // the quantisation's part of it
};

// What stays the same from picture to picture: one element per element of a SkyPicture.
struct ElementGeometry {
  Image<glm::vec3> direction;             // world frame; zero where the lens does not reach
  Image<glm::vec3> gain;                  // light of a full-scale pixel: vignetting and white balance undone
  Image<float> solid_angle;               // [sr] of the element
  Image<std::uint8_t> open;               // 1: above the horizon and not under the obstruction mask
  Image<std::uint8_t> patch;              // of the sky, kRings by kSectors, in which an open element lies
  std::vector<glm::vec3> light_of_level;  // linear light of evenly spaced encoded levels, 0 .. 1
  double rim_px = 1.0;                    // the farthest element that the lens reaches, from its axis
  glm::dmat3 light_to_xyz{1.0};
  double step = 1.0;
  glm::dvec2 first{};
  bool fits(const SkyPicture& picture) const;
  static constexpr int kRings = 3, kSectors = 8;  // enough to see a gradient, each with enough elements for a median
};
ElementGeometry sky_geometry(const Camera& camera, const SkyPicture& picture);

// Why an element is not sampled.
enum class PixelUse : std::uint8_t { outside, near_sun, saturated, dark, cloud, clear };

// Light of every element and whether it may be sampled; clouds are not yet marked.
struct ElementLight {
  Image<PixelUse> use;
  Image<glm::vec3> light;      // linear camera channels, vignetting and white balance removed; where use is clear
  Image<float> log_luminance;  // where use is clear
};
ElementLight sky_light(const SkyPicture& picture, const ElementGeometry& geometry, const SunDirection& sun,
                       const SampleLimits& limits);
// The same with a smaller least distance from the sun, of `sky` with a larger one: only what was near the sun is read.
void read_nearer(ElementLight& sky, const SkyPicture& picture, const ElementGeometry& geometry, const SunDirection& sun,
                 const SampleLimits& limits);

// `count` elements whose use is clear, drawn uniformly in solid angle, without repetition; all of them if there are
// fewer.
std::vector<glm::ivec2> draw_elements(const ElementLight& sky, const ElementGeometry& geometry, int count,
                                      std::mt19937_64& random);
std::vector<LuminanceSample> samples_at(std::span<const glm::ivec2> elements, const SkyPicture& picture,
                                        const ElementGeometry& geometry, const ElementLight& sky, const Camera& camera,
                                        const SunDirection& sun, const SampleLimits& limits);

// The same doubles from the same seed with every standard library: [0, 1).
double uniform(std::mt19937_64& random);

}  // namespace kasumi
