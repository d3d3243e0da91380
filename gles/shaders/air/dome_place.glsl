// For a vertex that leaves the sky to the fragments.
#include "shared.glsl"
#include "sky_projection.glsl"

uniform vec2 place_to_clip;
