#include "gles/model/specular_glossiness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

constexpr float kDielectric = 0.04f;

float from_srgb(int value) {
  static const auto kLight = [] {
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double v = static_cast<double>(i) / 255.0;
      light[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return light;
  }();
  return kLight[static_cast<std::size_t>(value)];
}

std::uint8_t to_srgb(float light) {
  const float v = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(v, 0.0f, 1.0f)));
}

glm::vec3 light_of(const glm::u8vec4& texel) {
  return {from_srgb(texel.r), from_srgb(texel.g), from_srgb(texel.b)};
}

float brightness(const glm::vec3& colour) {
  return std::sqrt(glm::dot(glm::vec3(0.299f, 0.587f, 0.114f), colour * colour));
}

// The share of metal that reflects and scatters as much as the two colours say.
float metallic_of(float diffuse, float specular, float rest) {
  if (specular < kDielectric) return 0.0f;
  const float b = diffuse * rest / (1.0f - kDielectric) + specular - 2.0f * kDielectric;
  const float c = kDielectric - specular;
  const float root = std::sqrt(std::max(b * b - 4.0f * kDielectric * c, 0.0f));
  return std::clamp((-b + root) / (2.0f * kDielectric), 0.0f, 1.0f);
}

}  // namespace

MetalRough metal_rough(const Image<glm::u8vec4>& diffuse, const glm::vec4& diffuse_factor,
                       const Image<glm::u8vec4>& specular_gloss, const glm::vec3& specular_factor, float gloss_factor) {
  const int width = std::max(diffuse.width(), specular_gloss.width());
  const int height = std::max(diffuse.height(), specular_gloss.height());
  MetalRough made{Image<glm::u8vec4>(width, height), Image<glm::u8vec4>(width, height)};
  // The texel of a smaller picture that covers this place.
  const auto at = [&](const Image<glm::u8vec4>& picture, int x, int y) {
    if (picture.empty()) return glm::u8vec4(255);
    return picture.at(static_cast<int>(std::int64_t{x} * picture.width() / width),
                      static_cast<int>(std::int64_t{y} * picture.height() / height));
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::u8vec4 d = at(diffuse, x, y), s = at(specular_gloss, x, y);
      const glm::vec3 scattered = light_of(d) * glm::vec3(diffuse_factor), mirrored = light_of(s) * specular_factor;
      const float rest = 1.0f - std::max({mirrored.r, mirrored.g, mirrored.b});
      const float metallic = metallic_of(brightness(scattered), brightness(mirrored), rest);
      const glm::vec3 by_diffuse = scattered * (rest / (1.0f - kDielectric) / std::max(1.0f - metallic, 1e-6f));
      const glm::vec3 by_specular = (mirrored - kDielectric * (1.0f - metallic)) / std::max(metallic, 1e-6f);
      const glm::vec3 colour = glm::mix(by_diffuse, by_specular, metallic * metallic);
      made.colour.at(x, y) = {to_srgb(colour.r), to_srgb(colour.g), to_srgb(colour.b), d.a};
      const float rough = 1.0f - gloss_factor * static_cast<float>(s.a) / 255.0f;
      made.roughness.at(x, y) = {0, std::lround(255.0f * std::clamp(rough, 0.0f, 1.0f)), std::lround(255.0f * metallic),
                                 255};
    }
  return made;
}

}  // namespace kasumi
