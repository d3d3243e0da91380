// Fraction of the sun's disc visible from a point past the model: by rays to points of the disc, in double precision
// and none of the renderer's code.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gles/model/model.hpp"

namespace kasumi {

class ReferenceShadow {
 public:
  // alpha: opacity of a part's material at its texture coordinates; triangles of blended materials cast no shadow.
  ReferenceShadow(const Model& model, const glm::dmat4& model_to_world, const glm::dvec3& sun,
                  std::function<double(const ModelMaterial&, glm::dvec2)> alpha);
  // 0..1, of `point` in the world.
  double seen(const glm::dvec3& point) const;

 private:
  struct Caster {
    std::array<glm::dvec3, 3> corners;
    std::array<glm::dvec2, 3> places;
    const ModelMaterial* material;
  };
  bool hides(const Caster& caster, const glm::dvec3& from, const glm::dvec3& towards) const;
  glm::ivec2 cell_of(glm::dvec2 across) const;

  static constexpr int kCells = 64;  // along a side of a grid across the sun's direction
  std::function<double(const ModelMaterial&, glm::dvec2)> alpha_;
  std::vector<Caster> casters_;
  std::vector<glm::dvec3> towards_;  // points of the disc
  glm::dvec3 across_{}, up_{};
  glm::dvec2 lowest_{1e300}, highest_{-1e300};
  std::vector<std::vector<std::size_t>> cells_;
};

}  // namespace kasumi
