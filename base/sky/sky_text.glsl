// The shader sources shared with the CPU, for GLSL ES 1.00 (base/sky/sky_text.hpp for C++).
#include "shared.glsl"
#include "tone.glsl"
#include "sky_projection.glsl"
#include "air_path.glsl"
#include "older_skies.glsl"
#include "dome.glsl"
