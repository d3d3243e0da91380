// A lens as data: which model and its numbers, as a configuration writes them. What calibration makes, moves and
// writes.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "calib/lens/lens.hpp"

namespace kasumi {

// r = f theta, or r = 2 f sin(theta / 2)
struct IdealFisheyeParameters {
  glm::dvec2 centre{};
  double focal_px = 1.0;
  bool equisolid = false;
};
struct OpencvFisheyeParameters {
  glm::dvec2 focal_px{1.0};
  glm::dvec2 centre{};
  std::array<double, 4> k{};
};

struct LensDescription {
  std::variant<IdealFisheyeParameters, OpencvFisheyeParameters, ScaramuzzaParameters, PinholeParameters> model;
  Radians largest_angle = from_degrees(90.0);  // without meaning for a pinhole
  bool mirrored = false;                       // fisheyes: the picture is turned over, left to right
};

LensPtr make_lens(const LensDescription& description);
std::string_view model_name(const LensDescription& description);  // as the key `model` has it
glm::dvec2 centre_of(const LensDescription& description);
// Pixels per radian on the optical axis, the mean of both directions.
double focal_px_of(const LensDescription& description);
// The same lens, shifted and scaled on the sensor: every radius times `scale` about the new centre.
LensDescription moved(LensDescription description, const glm::dvec2& centre, double scale);
// [lens], as read_lens reads it.
LensDescription read_lens_description(const ConfigTable& table);
// The keys of [lens], one a line, with as many digits as their values have.
std::string toml_of(const LensDescription& description);

}  // namespace kasumi
