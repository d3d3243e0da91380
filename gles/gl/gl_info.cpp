#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

#include "gles/gl/context.hpp"
#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

std::string gl_text(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(text));
}

bool is_software(const std::string& renderer) {
  constexpr std::array<std::string_view, 4> kRasterizers{"llvmpipe", "softpipe", "swrast", "SwiftShader"};
  return std::ranges::any_of(kRasterizers, [&](std::string_view r) { return renderer.find(r) != std::string::npos; });
}

}  // namespace

GlInfo query_gl_info() {
  GlInfo info;
  info.renderer = gl_text(GL_RENDERER);
  info.vendor = gl_text(GL_VENDOR);
  info.version = gl_text(GL_VERSION);
  info.software = is_software(info.renderer);
  int major = 0;
  if (std::sscanf(info.version.c_str(), "OpenGL ES %d", &major) == 1) info.es_major = major;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &info.max_texture_size);

  std::array<GLint, 2> range{};
  GLint precision = 0;
  glGetShaderPrecisionFormat(GL_FRAGMENT_SHADER, GL_HIGH_FLOAT, range.data(), &precision);
  info.highp_fragments = precision > 0;

  std::istringstream words(gl_text(GL_EXTENSIONS));
  for (std::string word; words >> word;) info.extensions.insert(word);
  return info;
}

}  // namespace kasumi
