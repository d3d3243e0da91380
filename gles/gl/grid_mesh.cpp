#include "gles/gl/grid_mesh.hpp"

#include <cstdint>

#include "gles/gl/gl.hpp"

namespace kasumi {

Result<GridMesh> GridMesh::create(int columns, int rows, int floats_per_point, std::span<const float> values,
                                  std::initializer_list<GridAttribute> attributes) {
  const auto points = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (columns < 2 || columns > 32767 || rows < 2 ||
      values.size() != points * static_cast<std::size_t>(floats_per_point))
    return fail(FaultKind::bad_input,
                "a grid of {} x {} points with {} values: expected 2 .. 32767 columns, 2 rows, {} values", columns,
                rows, values.size(), points * static_cast<std::size_t>(floats_per_point));
  GridMesh mesh;
  mesh.columns_ = columns;
  mesh.rows_ = rows;
  mesh.floats_per_point_ = floats_per_point;
  mesh.attributes_ = attributes;
  std::vector<std::uint16_t> strip;
  for (int column = 0; column < columns; ++column) {
    strip.push_back(static_cast<std::uint16_t>(column + columns));
    strip.push_back(static_cast<std::uint16_t>(column));
  }
  mesh.points_ = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, mesh.points_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  mesh.strip_ = make_buffer();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh.strip_.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(strip.size() * sizeof(std::uint16_t)), strip.data(),
               GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
  if (auto made = check_gl("uploading a grid of points"); !made) return fail(made.error());
  return mesh;
}

void GridMesh::draw() const {
  glBindBuffer(GL_ARRAY_BUFFER, points_.name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, strip_.name());
  for (const auto& attribute : attributes_) glEnableVertexAttribArray(attribute.place);
  const std::size_t stride = static_cast<std::size_t>(floats_per_point_) * sizeof(float);
  for (int row = rows_ - 2; row >= 0; --row) {
    const std::size_t start = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) * stride;
    for (const auto& attribute : attributes_)
      glVertexAttribPointer(
          attribute.place, attribute.floats, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
          reinterpret_cast<const void*>(start + static_cast<std::size_t>(attribute.offset_floats) * sizeof(float)));
    glDrawElements(GL_TRIANGLE_STRIP, 2 * columns_, GL_UNSIGNED_SHORT, nullptr);
  }
  for (const auto& attribute : attributes_) glDisableVertexAttribArray(attribute.place);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

}  // namespace kasumi
