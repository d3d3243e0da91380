// From the rotated lattice of samples to pixels: the mean of the 17 samples inside each pixel (object_layer.cpp), what
// stands in front taken off.
uniform sampler2D samples;
uniform mat3 fragment_to_sample;  // gl_FragCoord to texture coordinates of the pixel's central sample
uniform vec2 sample_step;         // one texel
uniform vec2 offsets[17];
#if defined(FOREGROUND)
uniform sampler2D foreground;
uniform mat3 fragment_to_picture;
#endif

void main() {
  vec2 centre = (fragment_to_sample * vec3(gl_FragCoord.xy, 1.0)).xy;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 17; ++i) sum += texture2D(samples, centre + offsets[i] * sample_step);
  vec4 mean = sum / 17.0;
#if defined(FOREGROUND)
  mean *= texture2D(foreground, (fragment_to_picture * vec3(gl_FragCoord.xy, 1.0)).xy).r;
#endif
#if defined(LAYER_IN_8_BITS)
  // Square roots spend the 8 bits as the eye does.
  gl_FragColor = vec4(sqrt(mean.rgb) + dither() * step(0.0005, mean.a), mean.a);
#else
  gl_FragColor = mean;
#endif
}
