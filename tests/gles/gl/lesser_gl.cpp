#include "tests/gles/gl/lesser_gl.hpp"

#include <dlfcn.h>

#include <array>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include <GLES3/gl31.h>

namespace kasumi {
namespace {

FragmentPrecision precision = FragmentPrecision::driver;
const GlLimits* limits = nullptr;
GlUse most;
std::map<GLuint, std::string> refused;  // programs that a smaller GPU would not link, and why

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define REAL(name) real<decltype(name)>(#name)

std::string replaced(const std::string& text, const char* what, const std::string& by) {
  return std::regex_replace(text, std::regex(what), by);
}

// After #version and #extension lines, which must come first.
std::string in_precision(const std::string& text) {
  if (precision == FragmentPrecision::medium)
    return replaced(replaced(text, "GL_FRAGMENT_PRECISION_HIGH", "NO_HIGH_PRECISION"), "\\bhighp\\b", "mediump");
  const std::string samplers = "precision highp sampler2D;\nprecision highp float;\n";
  const auto place = text.find("precision highp float;");
  return place == std::string::npos ? text : std::string(text).insert(place, samplers);
}

// The variables of one kind in a program of one shader, and the vectors they take as GLES 2 packs them (GLSL ES 1.00,
// appendix A.7, for what we have: a row for each vec4, vec3 and row of a matrix; two vec2 share one, and single numbers
// fill what is left).
struct Variables {
  int vectors = 0;
  std::string names;
};
Variables variables_of(GLuint program, GLenum kind) {
  std::map<GLint, int> count;
  Variables found;
  GLint variables = 0;
  glGetProgramInterfaceiv(program, kind, GL_ACTIVE_RESOURCES, &variables);
  for (GLint i = 0; i < variables; ++i) {
    const std::array<GLenum, 2> asked{GL_TYPE, GL_ARRAY_SIZE};
    std::array<GLint, 2> told{};
    glGetProgramResourceiv(program, kind, static_cast<GLuint>(i), 2, asked.data(), 2, nullptr, told.data());
    std::array<char, 200> name{};
    glGetProgramResourceName(program, kind, static_cast<GLuint>(i), name.size(), nullptr, name.data());
    if (std::string(name.data()).starts_with("gl_")) continue;
    count[told[0]] += told[1];
    found.names += std::string(name.data()) + ", ";
  }
  const int threes = count[GL_FLOAT_VEC3] + 3 * count[GL_FLOAT_MAT3], twos = count[GL_FLOAT_VEC2];
  found.vectors = count[GL_FLOAT_VEC4] + 4 * count[GL_FLOAT_MAT4] + threes + (twos + 1) / 2;
  const int left = threes + 2 * (twos % 2), ones = count[GL_FLOAT] + count[GL_INT] + count[GL_BOOL];
  found.vectors += (std::max(ones - left, 0) + 3) / 4;
  return found;
}

// Why this program would not link within the limits; empty: it would.
std::string beyond_limits(GLuint program) {
  std::array<GLuint, 2> shaders{};
  GLsizei count = 0;
  glGetAttachedShaders(program, 2, &count, shaders.data());
  std::ostringstream why;
  const auto check = [&](const Variables& v, int allowed, const char* what) {
    if (v.vectors > allowed) why << v.vectors << " " << what << ": this GPU has " << allowed << ": " << v.names << "\n";
  };
  for (GLsizei i = 0; i < count; ++i) {
    GLint type = 0, size = 0;
    glGetShaderiv(shaders[static_cast<std::size_t>(i)], GL_SHADER_TYPE, &type);
    glGetShaderiv(shaders[static_cast<std::size_t>(i)], GL_SHADER_SOURCE_LENGTH, &size);
    std::string text(static_cast<std::size_t>(size), '\0');
    glGetShaderSource(shaders[static_cast<std::size_t>(i)], size, nullptr, text.data());
    const char* start = text.c_str();
    const GLuint alone = glCreateShaderProgramv(static_cast<GLenum>(type), 1, &start);
    const Variables uniforms = variables_of(alone, GL_UNIFORM);
    if (type == GL_VERTEX_SHADER) {
      check(uniforms, limits->vertex_uniform_vectors, "vertex uniform vectors");
      if (uniforms.vectors > most.vertex_uniform_vectors) most.most_vertex_uniforms = uniforms.names;
      most.vertex_uniform_vectors = std::max(most.vertex_uniform_vectors, uniforms.vectors);
    } else {
      check(uniforms, limits->fragment_uniform_vectors, "fragment uniform vectors");
      most.fragment_uniform_vectors = std::max(most.fragment_uniform_vectors, uniforms.vectors);
      const Variables varyings = variables_of(alone, GL_PROGRAM_INPUT);
      check(varyings, limits->varying_vectors, "varying vectors");
      if (varyings.vectors > most.varying_vectors) most.most_varyings = varyings.names;
      most.varying_vectors = std::max(most.varying_vectors, varyings.vectors);
    }
    glDeleteProgram(alone);
  }
  return why.str();
}

constexpr const char* kExtensionsOfVc4 =
    "GL_EXT_unpack_subimage GL_OES_EGL_image GL_OES_EGL_image_external GL_OES_depth24 GL_OES_depth_texture "
    "GL_OES_texture_npot";

}  // namespace

void set_fragment_precision(FragmentPrecision wanted) {
  precision = wanted;
}
void set_gl_limits(const GlLimits* wanted) {
  limits = wanted;
}
const GlUse& gl_use() {
  return most;
}

}  // namespace kasumi

using kasumi::limits;
using kasumi::real;
using kasumi::refused;

extern "C" {

void glShaderSource(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths) {
  std::string text;
  for (GLsizei i = 0; i < count; ++i)
    text += lengths == nullptr || lengths[i] < 0 ? std::string(texts[i])
                                                 : std::string(texts[i], static_cast<std::size_t>(lengths[i]));
  GLint type = 0;
  glGetShaderiv(shader, GL_SHADER_TYPE, &type);
  if (type == GL_FRAGMENT_SHADER && kasumi::precision != kasumi::FragmentPrecision::driver)
    text = kasumi::in_precision(text);
  const GLchar* start = text.c_str();
  REAL(glShaderSource)(shader, 1, &start, nullptr);
}

void glGetShaderPrecisionFormat(GLenum shader, GLenum kind, GLint* range, GLint* digits) {
  REAL(glGetShaderPrecisionFormat)(shader, kind, range, digits);
  if (kasumi::precision == kasumi::FragmentPrecision::medium && shader == GL_FRAGMENT_SHADER && kind == GL_HIGH_FLOAT)
    range[0] = range[1] = *digits = 0;
}

void glGetIntegerv(GLenum name, GLint* value) {
  REAL(glGetIntegerv)(name, value);
  if (limits == nullptr) return;
  if (name == GL_MAX_TEXTURE_SIZE || name == GL_MAX_RENDERBUFFER_SIZE) *value = limits->texture_size;
  if (name == GL_MAX_VARYING_VECTORS) *value = limits->varying_vectors;
  if (name == GL_MAX_VERTEX_UNIFORM_VECTORS) *value = limits->vertex_uniform_vectors;
  if (name == GL_MAX_FRAGMENT_UNIFORM_VECTORS) *value = limits->fragment_uniform_vectors;
}

const GLubyte* glGetString(GLenum name) {
  const char* small = name == GL_EXTENSIONS ? kasumi::kExtensionsOfVc4
                      : name == GL_VERSION  ? "OpenGL ES 2.0 within limits"
                                            : nullptr;
  return limits != nullptr && small != nullptr ? reinterpret_cast<const GLubyte*>(small) : REAL(glGetString)(name);
}

void glTexImage2D(GLenum target, GLint level, GLint inside, GLsizei width, GLsizei height, GLint border, GLenum format,
                  GLenum type, const void* pixels) {
  if (limits != nullptr && std::max(width, height) > limits->texture_size) width = -1;  // GL_INVALID_VALUE, as there
  REAL(glTexImage2D)(target, level, inside, width, height, border, format, type, pixels);
}

void glRenderbufferStorage(GLenum target, GLenum format, GLsizei width, GLsizei height) {
  if (limits != nullptr && std::max(width, height) > limits->texture_size) width = -1;
  REAL(glRenderbufferStorage)(target, format, width, height);
}

void glLinkProgram(GLuint program) {
  refused.erase(program);
  REAL(glLinkProgram)(program);
  if (limits == nullptr) return;
  if (const std::string why = kasumi::beyond_limits(program); !why.empty()) refused[program] = why;
}

void glGetProgramiv(GLuint program, GLenum name, GLint* value) {
  REAL(glGetProgramiv)(program, name, value);
  const auto why = refused.find(program);
  if (why == refused.end()) return;
  if (name == GL_LINK_STATUS) *value = GL_FALSE;
  if (name == GL_INFO_LOG_LENGTH) *value = static_cast<GLint>(why->second.size() + 1);
}

void glGetProgramInfoLog(GLuint program, GLsizei room, GLsizei* length, GLchar* log) {
  const auto why = refused.find(program);
  if (why == refused.end()) return REAL(glGetProgramInfoLog)(program, room, length, log);
  const std::size_t copied = why->second.copy(log, static_cast<std::size_t>(room - 1));
  log[copied] = '\0';
  if (length != nullptr) *length = static_cast<GLsizei>(copied);
}

}  // extern "C"
