// From the model's vertices to the scene camera's pixels, on the CPU in double precision.
#pragma once

#include <optional>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include "base/result.hpp"
#include "gles/gl/program.hpp"
#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

struct Projection {
  SceneView view;
  int margin_px = 0;  // how far beyond the picture's border to keep geometry
  glm::dmat4 model_to_world{1.0};
  glm::dmat4 model_to_camera{1.0};
  glm::dmat3 normal_to_world{1.0};
  glm::dmat3 tangent_to_world{1.0};  // model to world, unscaled
  glm::dmat3 camera_to_world{1.0};
  bool left_handed = false;  // model to world mirrors
  glm::dvec3 camera_up{};    // the world's vertical in the camera's frame
  bool distorted = false;
  double lens_reach = 1e6;  // normalised radius up to which the distortion polynomial is used
  bool mirrored = false;    // the transforms change handedness
};

// Errors (bad_input, all at once): sizes, focal lengths, planes, matrices that are not finite or not invertible, a
// distortion that folds the picture over itself.
Result<Projection> make_projection(const SceneView& view, const glm::dmat4& model_to_world);

// The pixel of a point at depth z > 0.
glm::dvec2 pixel_of(const Projection& projection, const glm::dvec3& camera);

// The pixels that triangles can touch, plus one, clipped to the picture and its margin.
PixelBox box_of(const Projection& projection, std::span<const glm::vec3> positions,
                std::span<const std::uint16_t> indices);
PixelBox grown(const PixelBox& box, int px);  // on every side; an empty box stays empty
PixelBox cut_to_picture(const PixelBox& box, const SceneView& view);
PixelBox united(const PixelBox& a, const PixelBox& b);
PixelBox common(const PixelBox& a, const PixelBox& b);
bool overlap(const PixelBox& a, const PixelBox& b);

// Near and far planes as tight around the model as the view allows, so that a 16-bit depth buffer suffices.
struct DepthRange {
  double near_m = 0.0;
  double far_m = 0.0;
};
DepthRange depth_range(const Projection& projection, const ModelBounds& bounds);

// Uniforms of object.vert that follow from the view.
void set_projection(const Program& program, const Projection& projection, const DepthRange& depth);

}  // namespace kasumi
