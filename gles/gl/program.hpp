// A linked shader program and its uniforms.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

using Defines = std::set<std::string>;  // "RESPONSE_SRGB"

// Vertex attribute locations, the same in every program.
enum Attribute : unsigned {
  kPosition = 0,
  kNormal = 1,
  kTexturePlace = 2,
  kColour = 3,
  kSecondPlace = 4,
  kTangent = 5,
};

class Program {
 public:
  // Builds a program from two files of gles/shaders with these defines.
  static Result<Program> build(const Defines& defines, std::string_view vertex_file, std::string_view fragment_file);

  void use() const;
  // Set uniforms of the program in use; those the driver has optimised away are ignored.
  void set(std::string_view name, int value) const;
  void set(std::string_view name, double value) const;
  void set(std::string_view name, const glm::dvec2& value) const;
  void set(std::string_view name, const glm::dvec3& value) const;
  void set(std::string_view name, const glm::dvec4& value) const;
  void set(std::string_view name, const glm::dmat3& value) const;
  void set(std::string_view name, const glm::dmat4& value) const;
  void set(std::string_view name, std::span<const double> values) const;
  void set(std::string_view name, std::span<const glm::dvec2> values) const;
  void set(std::string_view name, std::span<const glm::dvec3> values) const;
  void set(std::string_view name, std::span<const glm::dvec4> values) const;

 private:
  explicit Program(GlProgram program) : program_(std::move(program)) {}
  int place_of(std::string_view name) const;

  GlProgram program_;
  mutable std::map<std::string, int, std::less<>> places_;
};

}  // namespace kasumi
