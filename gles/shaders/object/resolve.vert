// The places that resolve.frag reads, computed here in high precision: as they come they address every texel even where
// fragments have 16 bits.
attribute vec2 position;          // -1..1
uniform vec4 viewport;            // of the tile in the layer: first pixel, half of its size
uniform mat3 fragment_to_sample;  // gl_FragCoord to texture coordinates of the pixel's central sample
varying vec2 v_centre;
#if defined(MEANS)
uniform vec3 mean_place;        // what is added to gl_FragCoord; one texel
varying vec2 v_mean;            // texture coordinates of the pixel's mean
#endif
#if defined(FOREGROUND)
uniform mat3 fragment_to_picture;
varying vec2 v_picture;
#endif

void main() {
  vec3 fragment = vec3(viewport.xy + (position + 1.0) * viewport.zw, 1.0);
  v_centre = (fragment_to_sample * fragment).xy;
#if defined(MEANS)
  v_mean = (fragment.xy + mean_place.xy) * mean_place.z;
#endif
#if defined(FOREGROUND)
  v_picture = (fragment_to_picture * fragment).xy;
#endif
  gl_Position = vec4(position, 0.0, 1.0);
}
