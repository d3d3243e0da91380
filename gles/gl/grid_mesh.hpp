// Points in rows, drawn as one strip of triangles between each row and the next.
#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

// One attribute of a point: where in it, how many floats.
struct GridAttribute {
  unsigned place;
  int floats;
  int offset_floats;
};

class GridMesh {
 public:
  // values: floats_per_point for each of columns x rows points, rows first; columns <= 32767. Errors: device.
  static Result<GridMesh> create(int columns, int rows, int floats_per_point, std::span<const float> values,
                                 std::initializer_list<GridAttribute> attributes);
  // From the last row to the first: who puts far rows last has near ones painted over them.
  void draw() const;

 private:
  int columns_ = 0, rows_ = 0, floats_per_point_ = 0;
  std::vector<GridAttribute> attributes_;
  GlBuffer points_, strip_;
};

}  // namespace kasumi
