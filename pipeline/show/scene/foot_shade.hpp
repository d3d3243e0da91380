// The sky's light that the object hides from the ground around its foot: of the radiance of each part of the sky,
// weighted with the cosine of the angle to the ground's normal, what reaches the ground (physics 6). The sky's
// hemisphere is sampled in a set of directions; for each, the object is drawn into a height map towards it. Light that
// the object itself throws on the ground is left out.
#pragma once

#include <bitset>
#include <cstddef>
#include <memory>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// From which directions of the sky which ground is seen.
class GroundExposure {
 public:
  FootShade under(const LightAround& around) const;

 private:
  friend class FootShadeWork;
  // Chosen: a bound on the time that the shade of a small model takes.
  static constexpr int kMostDirections = 256;
  struct Ground {
    glm::vec3 normal{0.0f};  // zero: none here
    float up_m = 0.0f;
    std::bitset<kMostDirections> hidden;
  };
  glm::dvec2 first_m_{}, step_m_{1.0};
  Image<Ground> ground_;
  std::vector<glm::vec3> directions_;  // as dense as the cosine to the vertical
};

// Done in pieces, because a model of many triangles takes seconds.
class FootShadeWork {
 public:
  static constexpr std::size_t kMostTriangles = 1'000'000;  // of the object; beyond, there is no work

  // `model` is used only here. Masked materials count as closed, see-through ones as open. There is no work where the
  // model has no ground or too many triangles.
  FootShadeWork(const Model& model, const glm::dmat4& model_to_world);

  // From some directions of the sky; true: it is whole.
  bool step();
  // Null: there is none. Call it when it is whole.
  std::shared_ptr<const GroundExposure> take();

 private:
  void lay_ground(const Model& model, const glm::dmat4& model_to_world);
  void look_from(std::size_t number);

  std::vector<glm::vec3> corners_;  // of the object's triangles, world
  GroundExposure made_;
  std::size_t done_ = 0;  // directions
};

// All at once.
std::shared_ptr<const GroundExposure> sky_over_ground(const Model& model, const glm::dmat4& model_to_world);

}  // namespace kasumi
