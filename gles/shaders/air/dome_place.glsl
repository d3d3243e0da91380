// For vertices when the sky is computed per fragment.
#include "shared.glsl"
#include "sky_projection.glsl"

uniform vec2 place_to_clip;
