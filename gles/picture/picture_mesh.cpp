#include "gles/picture/picture_mesh.hpp"

#include <vector>

#include <glm/vec2.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {

PictureMesh PictureMesh::upload(const CutRectangles& rectangles) {
  PictureMesh mesh;
  std::vector<glm::vec2> corners;
  for (std::size_t area = 0; area < kCutAreas; ++area) {
    for (const PixelBox& box : rectangles[area]) {
      const glm::vec2 a(box.left, box.top), b(box.right, box.top), c(box.left, box.bottom), d(box.right, box.bottom);
      corners.insert(corners.end(), {a, b, c, c, b, d});
    }
    mesh.first_[area + 1] = static_cast<int>(corners.size());
  }
  mesh.corners_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, mesh.corners_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(glm::vec2)), corners.data(),
               GL_STATIC_DRAW);
  return mesh;
}

bool PictureMesh::empty(CutArea area) const {
  const auto at = static_cast<std::size_t>(area);
  return first_[at] == first_[at + 1];
}

void PictureMesh::draw(CutArea area) const {
  if (empty(area)) return;
  const auto at = static_cast<std::size_t>(area);
  glBindBuffer(GL_ARRAY_BUFFER, corners_.name());
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, sizeof(glm::vec2), nullptr);
  glDrawArrays(GL_TRIANGLES, first_[at], first_[at + 1] - first_[at]);
  glDisableVertexAttribArray(kPosition);
}

}  // namespace kasumi
