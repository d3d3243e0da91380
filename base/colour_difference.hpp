// CIEDE2000 (CIE 142-2001; Sharma, Wu and Dalal 2005).
#pragma once

#include <glm/vec3.hpp>

namespace kasumi {

// CIELAB of a colour beside a white of D65 and that luminance.
glm::dvec3 lab_of(const glm::dvec3& xyz, double white_luminance);
// 1 is about the least difference that an eye sees side by side.
double ciede2000(const glm::dvec3& lab_1, const glm::dvec3& lab_2);

}  // namespace kasumi
