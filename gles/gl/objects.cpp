#include "gles/gl/objects.hpp"

#include <vector>

#include "gles/gl/gl.hpp"

namespace kasumi {

namespace gl_delete {
void texture(unsigned name) {
  glDeleteTextures(1, &name);
}
void buffer(unsigned name) {
  glDeleteBuffers(1, &name);
}
void framebuffer(unsigned name) {
  glDeleteFramebuffers(1, &name);
}
void renderbuffer(unsigned name) {
  glDeleteRenderbuffers(1, &name);
}
void program(unsigned name) {
  glDeleteProgram(name);
}
void shader(unsigned name) {
  glDeleteShader(name);
}
}  // namespace gl_delete

namespace {

using GlShader = GlName<gl_delete::shader>;

std::string_view reason(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
    default: return "an unknown GL error";
  }
}

template <class Query, class Log>
std::string log_of(unsigned name, Query query, Log log) {
  GLint length = 0;
  query(name, GL_INFO_LOG_LENGTH, &length);
  if (length <= 1) return "(no log from the driver)";
  std::string text(static_cast<std::size_t>(length), '\0');
  log(name, length, &length, text.data());
  text.resize(static_cast<std::size_t>(length));
  return text;
}

Result<GlShader> compile(std::string_view name, GLenum stage, const std::string& text) {
  GlShader shader(glCreateShader(stage));
  const char* lines = text.c_str();
  glShaderSource(shader.name(), 1, &lines, nullptr);
  glCompileShader(shader.name());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE)
    return fail(FaultKind::device, "shader {} ({}) does not compile: {}", name,
                stage == GL_VERTEX_SHADER ? "vertex" : "fragment",
                log_of(shader.name(), glGetShaderiv, glGetShaderInfoLog));
  return shader;
}

template <class Name, class Generate>
Name generate(Generate function) {
  GLuint name = 0;
  function(1, &name);
  return Name(name);
}

}  // namespace

GlTexture make_texture() {
  return generate<GlTexture>(glGenTextures);
}
GlBuffer make_buffer() {
  return generate<GlBuffer>(glGenBuffers);
}
GlFramebuffer make_framebuffer() {
  return generate<GlFramebuffer>(glGenFramebuffers);
}
GlRenderbuffer make_renderbuffer() {
  return generate<GlRenderbuffer>(glGenRenderbuffers);
}

void set_filter(TextureFilter filter) {
  const GLint value = filter == TextureFilter::linear ? GL_LINEAR : GL_NEAREST;
  for (const GLenum where : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, where, value);
}

void clamp_to_edge() {
  for (const GLenum side : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, side, GL_CLAMP_TO_EDGE);
}

Result<> check_gl(std::string_view what) {
  std::string reasons;
  // A lost context may report errors without end.
  for (int i = 0; i < 8; ++i) {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) break;
    reasons += fmt::format("{}{}", reasons.empty() ? "" : ", ", reason(error));
  }
  if (reasons.empty()) return {};
  return fail(FaultKind::device, "{}: {}", what, reasons);
}

void finish_gl() {
  glFinish();
}

void release_compiler() {
  glReleaseShaderCompiler();
}

Result<> check_framebuffer(std::string_view what) {
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return check_gl(what);
  return fail(FaultKind::device, "{}: framebuffer not supported by the driver (status {:#x})", what, status);
}

Result<GlProgram> link_program(std::string_view name, const std::string& vertex_text, const std::string& fragment_text,
                               std::initializer_list<AttributePlace> attributes) {
  auto vertex = compile(name, GL_VERTEX_SHADER, vertex_text);
  if (!vertex) return fail(vertex.error());
  auto fragment = compile(name, GL_FRAGMENT_SHADER, fragment_text);
  if (!fragment) return fail(fragment.error());
  GlProgram program(glCreateProgram());
  glAttachShader(program.name(), vertex->name());
  glAttachShader(program.name(), fragment->name());
  for (const AttributePlace& attribute : attributes)
    glBindAttribLocation(program.name(), attribute.place, attribute.name);
  glLinkProgram(program.name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE)
    return fail(FaultKind::device, "shader {} does not link: {}", name,
                log_of(program.name(), glGetProgramiv, glGetProgramInfoLog));
  for (const auto* shader : {&*vertex, &*fragment}) glDetachShader(program.name(), shader->name());  // and its text
  return program;
}

}  // namespace kasumi
