#include "tests/gles/gl/halves.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>

#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {

// 1 + 1/4096 is 1 in a half float.
bool computes_in_halves() {
  auto program = link_program(
      "a sum", "#version 100\nattribute vec2 position;\nvoid main() { gl_Position = vec4(position, 0.0, 1.0); }\n",
      "#version 100\nprecision mediump float;\nuniform float a, b, c;\n"
      "void main() { gl_FragColor = vec4((a + b - c) * 4096.0); }\n",
      {{kPosition, "position"}});
  if (!program) throw std::runtime_error(program.error().message);
  const GlTexture texture = make_texture();
  const GlFramebuffer framebuffer = make_framebuffer();
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 4, 4, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
  glViewport(0, 0, 4, 4);
  glUseProgram(program->name());
  const auto set = [&](const char* name, float value) {
    glUniform1f(glGetUniformLocation(program->name(), name), value);
  };
  set("a", 1.0f);
  set("b", 1.0f / 4096.0f);
  set("c", 1.0f);
  const std::array<float, 6> corners{-1, -1, 3, -1, -1, 3};
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, 0, corners.data());
  glEnableVertexAttribArray(kPosition);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisableVertexAttribArray(kPosition);
  std::array<std::uint8_t, 4> pixel{};
  glReadPixels(1, 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel.data());
  return pixel[0] < 128;
}

}  // namespace kasumi
