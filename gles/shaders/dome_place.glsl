// For a vertex that leaves the sky to the fragments.
uniform vec2 place_to_clip;
