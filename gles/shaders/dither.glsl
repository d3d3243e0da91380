// Half a step of 8 bits either way, an even spread over each 8 x 8 pixels: a smooth wall in haze would band without.
uniform sampler2D dither_pattern;
float dither() {
  // Texels 2, 6, .. 254 stand for -31.5/64 .. 31.5/64 of a step.
  return (texture2D(dither_pattern, gl_FragCoord.xy / 8.0).r * (255.0 / 256.0) - 0.5) / 255.0;
}
