#include "gles/composite/matte.hpp"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/gtc/type_precision.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/layer_buffer.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

// How far a node's pixel lies from it in one of the directions, and one; 0: there is none.
std::uint8_t steps_to(const std::optional<glm::ivec2>& pixel, const glm::ivec2& from) {
  if (!pixel) return 0;
  const glm::ivec2 way = glm::abs(*pixel - from);
  return static_cast<std::uint8_t>(1 + std::max(way.x, way.y));
}

// Of each node two texels, one below the other, of four directions each; those of what is in front to the right.
Image<glm::u8vec4> taps_of(const MatteNodes& nodes, const glm::ivec2& picture) {
  Image<glm::u8vec4> taps(2 * nodes.columns, 2 * nodes.rows, glm::u8vec4{0});
  for (const MatteNode& node : nodes.nodes) {
    const glm::ivec2 from = first_looked_at(nodes, node.at, picture);
    for (int i = 0; i < kMatteDirections; ++i) {
      const auto direction = static_cast<std::size_t>(i);
      taps.at(node.at.x, 2 * node.at.y + i / 4)[i % 4] = steps_to(node.clear[direction], from);
      taps.at(nodes.columns + node.at.x, 2 * node.at.y + i / 4)[i % 4] = steps_to(node.front[direction], from);
    }
  }
  return taps;
}

}  // namespace

Result<Matte> Matte::create(const MatteNodes& nodes, const glm::ivec2& picture) {
  Matte made;
  made.corner_px_ = nodes.corner_px;
  made.cell_px_ = nodes.cell_px;
  made.columns_ = nodes.columns;
  made.rows_ = nodes.rows;
  const auto taps = taps_of(nodes, picture);
  made.taps_ = make_texture();
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, made.taps_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, taps.width(), taps.height(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
               taps.elements().data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  made.texture_ = make_texture();
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, made.texture_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 2 * nodes.columns, nodes.rows, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  set_filter(TextureFilter::linear);
  clamp_to_edge();
  made.framebuffer_ = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, made.framebuffer_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, made.texture_.name(), 0);
  if (auto complete = check_framebuffer("the matte's nodes"); !complete) return fail(complete.error());
  return made;
}

Result<> Matte::follow(Programs& programs, const CameraTextures& camera, const ResponseOnGpu& response,
                       const GlTexture& dither) const {
  Defines defines = camera.defines();
  defines.insert(response.define());
  const auto program = programs.find(ProgramKind::matte, defines);
  if (!program) return fail(program.error());
  (*program)->use();
  camera.bind(**program, false);
  response.bind(**program, kResponseUnit);
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, dither.name());
  (*program)->set("dither_pattern", kDitherUnit);
  (*program)->set("picture_size", glm::dvec2{camera.width, camera.height});
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glViewport(0, 0, 2 * columns_, rows_);
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, taps_.name());
  (*program)->set("taps", kLayerUnit);
  (*program)->set("taps_step", 1.0 / glm::dvec2{2 * columns_, 2 * rows_});
  (*program)->set("columns", double(columns_));
  (*program)->set("corner_px", glm::dvec2(corner_px_));
  (*program)->set("cell_px", double(cell_px_));
  draw_square();
  return check_gl("reading the matte's nodes");
}

void Matte::bind(const Program& program, int unit, int width, int height) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  program.set("matte_nodes", unit);
  const glm::dvec2 nodes{columns_, rows_}, size{width, height}, first(corner_px_);
  const glm::dvec2 cells = nodes * double(cell_px_);
  program.set("matte_place", glm::dvec4(size / cells, -first / cells));
  program.set("matte_half", 0.5 / nodes);
  program.set("matte_last", 1.0 - 0.5 / nodes);
  program.set("pixel_step", 1.0 / size);
}

}  // namespace kasumi
