// Converts blurring haze from the estimator's structs to the renderer's.
#pragma once

#include "estimator/haze/haze_picture.hpp"
#include "gles/air/haze_blur.hpp"

namespace kasumi {

BlurInput haze_scene(const Image<glm::vec3>& light, const HazeRange& range);

// `scheme`: one the GPU has, explicit_steps or matched. `range`: of the picture; its farthest pixel determines the
// passes.
HazeLook haze_look(const HazeOptics& optics, const HazeRange& range, const glm::dvec3& airlight,
                   DiffusionScheme scheme = DiffusionScheme::matched);

}  // namespace kasumi
