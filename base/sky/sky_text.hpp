// The sky's shader sources compiled as C++ in double precision, and the few definitions that make GLSL valid C++. Only
// those definitions exist in both languages.
#pragma once

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace kasumi::sky_text {

using real = double;
using vec2 = glm::dvec2;
using vec3 = glm::dvec3;
using mat3 = glm::dmat3;
using glm::abs, glm::acos, glm::atan, glm::clamp, glm::cos, glm::dot, glm::exp, glm::length, glm::max, glm::min,
    glm::mix, glm::normalize, glm::pow, glm::sin, glm::smoothstep, glm::sqrt, glm::step;

#define FUNCTION inline
#include "base/sky/air_path.glsl"
#include "base/sky/dome.glsl"
#include "base/sky/older_skies.glsl"
#include "base/sky/sky_projection.glsl"
#include "base/sky/tone.glsl"
#undef FUNCTION

}  // namespace kasumi::sky_text
