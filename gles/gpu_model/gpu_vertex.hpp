// The GPU's vertex format: half the model's size where precision is not needed.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gles/gl/gl.hpp"
#include "gles/gl/program.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

struct GpuVertex {
  glm::vec3 position{};
  std::array<std::int16_t, 4> normal{};   // of 32767; a fourth for alignment
  std::array<std::int16_t, 4> tangent{};  // of 32767
  std::array<std::uint16_t, 4> colour{};  // of 65535
  glm::vec2 texture{};
  glm::vec2 texture_2{};

  explicit GpuVertex(const ModelVertex& v) : position(v.position), texture(v.texture), texture_2(v.texture_2) {
    for (int c = 0; c < 4; ++c) {
      const auto at = static_cast<std::size_t>(c);
      normal[at] = c < 3 ? of_unit(v.normal[c]) : std::int16_t{0};
      tangent[at] = of_unit(v.tangent[c]);
      colour[at] = static_cast<std::uint16_t>(std::lround(std::fmin(std::fmax(v.colour[c], 0.0f), 1.0f) * 65535.0f));
    }
  }

 private:
  static std::int16_t of_unit(float value) {
    return static_cast<std::int16_t>(std::lround(std::fmin(std::fmax(value, -1.0f), 1.0f) * 32767.0f));
  }
};

struct VertexAttribute {
  unsigned place;
  int components;
  GLenum type;
  std::size_t offset;
};
inline constexpr std::array<VertexAttribute, 6> kVertexAttributes{{
    {kPosition, 3, GL_FLOAT, offsetof(GpuVertex, position)},
    {kNormal, 3, GL_SHORT, offsetof(GpuVertex, normal)},
    {kTexturePlace, 2, GL_FLOAT, offsetof(GpuVertex, texture)},
    {kColour, 4, GL_UNSIGNED_SHORT, offsetof(GpuVertex, colour)},
    {kSecondPlace, 2, GL_FLOAT, offsetof(GpuVertex, texture_2)},
    {kTangent, 4, GL_SHORT, offsetof(GpuVertex, tangent)},
}};

}  // namespace kasumi
