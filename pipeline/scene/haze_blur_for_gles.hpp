// Haze that blurs, from the estimator's words to the renderer's.
#pragma once

#include "estimator/haze/haze_picture.hpp"
#include "gles/air/haze_blur.hpp"

namespace kasumi {

HazeScene haze_scene(const Image<glm::vec3>& light, const HazeRange& range);

// The GPU's schemes: explicit_steps and matched. `range`: of the picture, whose farthest pixel gives the passes.
HazeLook haze_look(const HazeOptics& optics, const HazeRange& range, const glm::dvec3& airlight,
                   DiffusionScheme scheme = DiffusionScheme::matched);

}  // namespace kasumi
