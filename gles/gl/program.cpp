#include "gles/gl/program.hpp"

#include <vector>

#include <glm/gtc/type_ptr.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/shader_text.hpp"

namespace kasumi {
namespace {

// HIGH: for samplers whose 11 bits, GLES 2's default for them, are too few.
constexpr std::string_view kFragmentPrecision =
    "#ifdef GL_FRAGMENT_PRECISION_HIGH\n"
    "#define HIGH highp\n"
    "precision highp float;\n"
    "#else\n"
    "#define HIGH mediump\n"
    "precision mediump float;\n"
    "#endif\n";

Result<std::string> assemble(const Defines& defines, std::string_view preamble, std::string_view file) {
  const std::string_view body = shader_text(file);
  if (body.empty()) return fail(FaultKind::device, "shader file {} is not part of this program", file);
  std::string text = "#version 100\n";
  for (const std::string& define : defines) text += fmt::format("#define {}\n", define);
  text += preamble;
  text += body;
  return text;
}

}  // namespace

Result<Program> Program::build(const Defines& defines, std::string_view vertex_file, std::string_view fragment_file) {
  const auto vertex = assemble(defines, "", vertex_file);
  if (!vertex) return fail(vertex.error());
  std::string preamble(kFragmentPrecision);
  if (defines.contains("LAYOUT_EXTERNAL")) preamble = "#extension GL_OES_EGL_image_external : require\n" + preamble;
  if (defines.contains("FACE_SLOPES")) preamble = "#extension GL_OES_standard_derivatives : require\n" + preamble;
  const auto fragment = assemble(defines, preamble, fragment_file);
  if (!fragment) return fail(fragment.error());
  std::string name(fragment_file);
  for (const std::string& define : defines) name += fmt::format(" {}", define);
  auto linked = link_program(name, *vertex, *fragment,
                             {{kPosition, "position"},
                              {kNormal, "normal"},
                              {kTexturePlace, "texture_place"},
                              {kColour, "colour"},
                              {kSecondPlace, "texture_place_2"},
                              {kTangent, "tangent"}});
  if (!linked) return fail(linked.error());
  return Program(std::move(*linked));
}

void Program::use() const {
  glUseProgram(program_.name());
}

int Program::place_of(std::string_view name) const {
  const auto known = places_.find(name);
  if (known != places_.end()) return known->second;
  const std::string text(name);
  return places_.emplace(text, glGetUniformLocation(program_.name(), text.c_str())).first->second;
}

void Program::set(std::string_view name, int value) const {
  glUniform1i(place_of(name), value);
}
void Program::set(std::string_view name, double value) const {
  glUniform1f(place_of(name), static_cast<float>(value));
}
void Program::set(std::string_view name, const glm::dvec2& value) const {
  glUniform2fv(place_of(name), 1, glm::value_ptr(glm::vec2(value)));
}
void Program::set(std::string_view name, const glm::dvec3& value) const {
  glUniform3fv(place_of(name), 1, glm::value_ptr(glm::vec3(value)));
}
void Program::set(std::string_view name, const glm::dvec4& value) const {
  glUniform4fv(place_of(name), 1, glm::value_ptr(glm::vec4(value)));
}
void Program::set(std::string_view name, const glm::dmat3& value) const {
  glUniformMatrix3fv(place_of(name), 1, GL_FALSE, glm::value_ptr(glm::mat3(value)));
}
void Program::set(std::string_view name, const glm::dmat4& value) const {
  glUniformMatrix4fv(place_of(name), 1, GL_FALSE, glm::value_ptr(glm::mat4(value)));
}
void Program::set(std::string_view name, std::span<const double> values) const {
  const std::vector<float> floats(values.begin(), values.end());
  glUniform1fv(place_of(name), static_cast<GLsizei>(floats.size()), floats.data());
}
void Program::set(std::string_view name, std::span<const glm::dvec2> values) const {
  const std::vector<glm::vec2> floats(values.begin(), values.end());
  glUniform2fv(place_of(name), static_cast<GLsizei>(floats.size()), glm::value_ptr(floats.front()));
}
void Program::set(std::string_view name, std::span<const glm::dvec3> values) const {
  const std::vector<glm::vec3> floats(values.begin(), values.end());
  glUniform3fv(place_of(name), static_cast<GLsizei>(floats.size()), glm::value_ptr(floats.front()));
}
void Program::set(std::string_view name, std::span<const glm::dvec4> values) const {
  const std::vector<glm::vec4> floats(values.begin(), values.end());
  glUniform4fv(place_of(name), static_cast<GLsizei>(floats.size()), glm::value_ptr(floats.front()));
}

}  // namespace kasumi
