// A grid of points, drawn as one triangle strip between each row and the next.
#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

// One attribute of a point: its offset and number of floats.
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
  // Draws from the last row to the first, so that near rows cover far ones if far rows come last.
  void draw() const;

 private:
  int columns_ = 0, rows_ = 0, floats_per_point_ = 0;
  std::vector<GridAttribute> attributes_;
  GlBuffer points_, strip_;
};

}  // namespace kasumi
