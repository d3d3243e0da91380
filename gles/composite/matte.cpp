#include "gles/composite/matte.hpp"

#include <vector>

#include <glm/vec4.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr int kVectors = 1 + kMatteDirections / 2;  // of a point: its place, and two pixels each
constexpr double kClearFalloff = -2.0;              // what is behind changes from place to place,
constexpr double kFrontFalloff = -1.0;              // leaves from one to the next

void add_points(std::vector<glm::vec4>& points, const MatteNodes& nodes, bool front) {
  for (const MatteNode& node : nodes.nodes) {
    const glm::dvec2 texel = glm::dvec2(node.at) + 0.5;
    const glm::dvec2 middle = glm::dvec2(nodes.corner_px) + texel * double(nodes.cell_px) - 0.5;
    points.emplace_back((texel.x + (front ? nodes.columns : 0)) / nodes.columns - 1.0, 2.0 * texel.y / nodes.rows - 1.0,
                        middle.x, middle.y);
    const auto& taps = front ? node.front : node.clear;
    for (std::size_t i = 0; i < taps.size(); i += 2) {
      const glm::vec2 a(taps[i].value_or(glm::ivec2{-1})), b(taps[i + 1].value_or(glm::ivec2{-1}));
      points.emplace_back(a, b);
    }
  }
}

}  // namespace

Result<Matte> Matte::create(const MatteNodes& nodes) {
  Matte made;
  made.corner_px_ = nodes.corner_px;
  made.cell_px_ = nodes.cell_px;
  made.columns_ = nodes.columns;
  made.rows_ = nodes.rows;
  made.points_ = static_cast<int>(nodes.nodes.size());
  std::vector<glm::vec4> points;
  add_points(points, nodes, false);
  add_points(points, nodes, true);
  made.buffer_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, made.buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(points.size() * sizeof(glm::vec4)), points.data(),
               GL_STATIC_DRAW);
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
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  const auto attribute = [](unsigned place, int vector) {
    glEnableVertexAttribArray(place);
    glVertexAttribPointer(place, 4, GL_FLOAT, GL_FALSE, kVectors * sizeof(glm::vec4),
                          reinterpret_cast<const void*>(static_cast<std::size_t>(vector) * sizeof(glm::vec4)));
  };
  attribute(kPosition, 0);
  for (int i = 1; i < kVectors; ++i) attribute(kTaps + static_cast<unsigned>(i - 1), i);
  for (const bool front : {false, true}) {
    (*program)->set("falloff", front ? kFrontFalloff : kClearFalloff);
    glDrawArrays(GL_POINTS, front ? points_ : 0, points_);
  }
  glDisableVertexAttribArray(kPosition);
  for (int i = 1; i < kVectors; ++i) glDisableVertexAttribArray(kTaps + static_cast<unsigned>(i - 1));
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
