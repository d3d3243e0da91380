// Ordered dither of +- half an 8-bit step over 8 x 8 pixels, against banding on smooth surfaces in haze.
uniform sampler2D dither_pattern;

// In steps. Texels 2, 6, .. 254 stand for -31.5/64 .. 31.5/64.
float dither(vec2 pixel) { return texture2D(dither_pattern, pixel / 8.0).r * (255.0 / 256.0) - 0.5; }
