#include "estimator/passers/tone.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

Tone::Tone(const Response& response) {
  for (int i = 0; i <= 256; ++i) {
    const glm::dvec3 light = response.to_light(glm::dvec3(std::min(i, 255) / 255.0));
    for (int c = 0; c < 3; ++c)
      light_[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)] = static_cast<float>(light[c]);
  }
  for (auto& codes : code_) codes.resize(kSteps + 2);
  for (int i = 0; i <= kSteps + 1; ++i) {
    const double root = std::min(i, kSteps) / double{kSteps};
    const glm::dvec3 code = response.to_encoded(glm::dvec3(root * root));
    for (int c = 0; c < 3; ++c)
      code_[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)] = static_cast<float>(255.0 * code[c]);
  }
}

float Tone::light(float code, int channel) const {
  const float at = std::clamp(code, 0.0F, 255.0F);
  const auto step = static_cast<std::size_t>(at);
  const auto& table = light_[static_cast<std::size_t>(channel)];
  return std::lerp(table[step], table[step + 1], at - static_cast<float>(step));
}

float Tone::code(float light, int channel) const {
  const float at = static_cast<float>(kSteps) * std::sqrt(std::clamp(light, 0.0F, 1.0F));
  const auto step = static_cast<std::size_t>(at);
  const auto& table = code_[static_cast<std::size_t>(channel)];
  return std::lerp(table[step], table[step + 1], at - static_cast<float>(step));
}

glm::vec3 Tone::to_light(const glm::vec3& code) const {
  return {light(code.r, 0), light(code.g, 1), light(code.b, 2)};
}

glm::vec3 Tone::to_code(const glm::vec3& light) const {
  return {code(light.r, 0), code(light.g, 1), code(light.b, 2)};
}

}  // namespace kasumi
