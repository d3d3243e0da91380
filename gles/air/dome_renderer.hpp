// The sky's dome, the sun and land under it, drawn by the GPU.
#pragma once

#include <memory>

#include "base/result.hpp"
#include "base/sky/dome_scene.hpp"
#include "gles/air/dome_land.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

// per_vertex: the sky is computed at the corners of a mesh that is fine where the picture bends, and is straight in
// between; off by less than half a step of 8 bits. per_fragment: in each pixel; no sun, no land. To measure the first
// by; it takes 45 uniform vectors of the fragment shader, and GLES 2 promises 16.
enum class DomeDetail { per_vertex, per_fragment };

class DomeRenderer {
 public:
  static Result<DomeRenderer> create(GlContext& context);
  DomeRenderer(DomeRenderer&&) noexcept;
  DomeRenderer& operator=(DomeRenderer&&) noexcept;
  ~DomeRenderer();

  // What is looked at from where, under what sky. Costs some milliseconds of the CPU, which cuts the mesh.
  // Errors: bad_input (no size, no focal length), device.
  Result<> set(const SkyView& view, const SkyScene& scene);
  // Stays until the next; an empty one takes it away. Preetham 1999 shows none. Errors: bad_input (sizes that
  // disagree), device.
  Result<> set_land(const DomeLand& land);
  // The picture as large as it fits. Errors: bad_input (nothing was set), device.
  Result<> draw(const DrawTarget& target, DomeDetail detail = DomeDetail::per_vertex);

  struct Size {
    int columns = 0, rows = 0;
  };
  Size mesh_size() const;  // for people and benches

 private:
  struct State;
  explicit DomeRenderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kasumi
