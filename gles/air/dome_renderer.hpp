// The sky's dome, the sun and land under it, drawn by the GPU.
#pragma once

#include <memory>

#include "base/result.hpp"
#include "base/sky/dome_scene.hpp"
#include "gles/air/dome_land.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

// per_vertex: the sky is computed at the vertices of an adaptive mesh and interpolated linearly, with an error below
// half a step of 8 bits. per_fragment: in each pixel, without sun and land; a reference for per_vertex that needs 45
// uniform vectors of the fragment shader, where GLES 2 guarantees 16.
enum class DomeDetail { per_vertex, per_fragment };

class DomeRenderer {
 public:
  static Result<DomeRenderer> create(GlContext& context);
  DomeRenderer(DomeRenderer&&) noexcept;
  DomeRenderer& operator=(DomeRenderer&&) noexcept;
  ~DomeRenderer();

  // Sets view and sky. Takes some milliseconds of CPU time to build the mesh.
  // Errors: bad_input (no size, no focal length), device.
  Result<> set(const PanoramaView& view, const DomeScene& scene);
  // Kept until replaced; an empty one removes it. Not drawn with Preetham 1999. Errors: bad_input (inconsistent sizes),
  // device.
  Result<> set_land(const DomeLand& land);
  // Draws the picture as large as fits. Errors: bad_input (no sky set), device.
  Result<> draw(const DrawTarget& target, DomeDetail detail = DomeDetail::per_vertex);

  struct Size {
    int columns = 0, rows = 0;
  };
  Size mesh_size() const;  // for display and benchmarks

 private:
  struct State;
  explicit DomeRenderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kasumi
