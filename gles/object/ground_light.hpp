// How the real ground around the object is lit, as ground.frag reads it while the layer is drawn.
#pragma once

#include <memory>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class GroundLight {
 public:
  // Nothing is uploaded of what is null. Errors: bad_input (larger than the driver's textures), device.
  static Result<GroundLight> upload(const ObjectAppearance& appearance, const glm::dmat4& model_to_world,
                                    const GlInfo& info);

  bool shades() const { return foot_shade_ != nullptr; }  // without any sun
  Defines defines() const;
  // Sets the uniforms and binds the textures of the program in use. The pixel (0, 0) is the centre of the top left one.
  void bind(const Program& program, const glm::dmat3& fragment_to_pixel) const;

 private:
  glm::dmat4 model_to_world_{1.0};
  std::shared_ptr<const GroundSunlight> sunlight_;
  std::shared_ptr<const FootShade> foot_shade_;
  GlTexture sunlight_texture_, foot_texture_;
};

}  // namespace kasumi
