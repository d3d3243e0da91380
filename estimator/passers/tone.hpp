// From a camera's 8-bit values to light and back, by tables: sums are valid in linear light only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "calib/light/radiometry.hpp"

namespace kasumi {

class Tone {
 public:
  explicit Tone(const Response& response = Response::srgb());
  // Values of 0..255, between whole ones, too; light of 0..1.
  glm::vec3 to_light(const glm::vec3& code) const;
  glm::vec3 to_code(const glm::vec3& light) const;
  float luma_to_light(std::uint8_t code) const { return light_[1][code]; }
  float luma_to_code(float light) const { return code(light, 1); }

 private:
  static constexpr int kSteps = 1024;  // of the root of light
  float light(float code, int channel) const;
  float code(float light, int channel) const;
  std::array<std::array<float, 257>, 3> light_{};
  std::array<std::vector<float>, 3> code_;
};

}  // namespace kasumi
