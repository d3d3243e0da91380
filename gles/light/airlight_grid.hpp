// Passes grids of airlight to the shaders.
#pragma once

#include <string>
#include <string_view>

#include "base/result.hpp"
#include "gles/gl/program.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// Bilinear between the grid's points, clamped beyond its edges. `pixel`: (0, 0) is the centre of the top left pixel.
glm::dvec3 airlight_at(const AirlightGrid& grid, const glm::dvec2& pixel);

// The same for a row of pixels, of a grid that outlives it.
class AirlightRow {
 public:
  AirlightRow(const AirlightGrid& grid, double y);
  glm::dvec3 at(double x) const;

 private:
  const glm::dvec3* above_;
  double share_below_, first_px_, points_per_px_;
};

// positive: also refuses zero, because the value is a divisor.
void check(const AirlightGrid& grid, std::string_view name, bool positive, Problems& problems);

// Uniforms NAME_light and NAME_place of airlight.glsl, and where the grid saturates that of saturation.glsl.
void set_airlight(const Program& program, const std::string& name, const AirlightGrid& grid);

}  // namespace kasumi
