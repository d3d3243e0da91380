// AirlightGrid::kColumns x kRows points, rows first. Sums over all points with tent weights, because GLSL ES 1.00
// guarantees only loop indices of constant bounds for uniform arrays in fragment shaders.
#define AIRLIGHT_COLUMNS 8
#define AIRLIGHT_ROWS 3

// place: pixel of point (0, 0); points per pixel. Bilinear, clamped beyond the edges.
vec3 airlight_on(vec3 light[AIRLIGHT_COLUMNS * AIRLIGHT_ROWS], vec4 place, vec2 pixel) {
  vec2 point = clamp((pixel - place.xy) * place.zw, vec2(0.0), vec2(float(AIRLIGHT_COLUMNS - 1), float(AIRLIGHT_ROWS - 1)));
  vec3 sum = vec3(0.0);
  for (int row = 0; row < AIRLIGHT_ROWS; ++row) {
    vec3 along = vec3(0.0);
    for (int column = 0; column < AIRLIGHT_COLUMNS; ++column)
      along += light[row * AIRLIGHT_COLUMNS + column] * max(0.0, 1.0 - abs(point.x - float(column)));
    sum += along * max(0.0, 1.0 - abs(point.y - float(row)));
  }
  return sum;
}
