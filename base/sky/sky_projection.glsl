// The viewing direction of a pixel. `place`: pixels right and down from the picture's middle; the result is in the
// camera's frame: x right, y down, z forward. Compiles as GLSL ES 1.00 and as C++ (base/sky/sky_text.hpp).

FUNCTION vec3 perspective_ray(vec2 place, real focal_px) { return normalize(vec3(place, focal_px)); }

// Equidistant: the angle from the axis grows linearly with the distance from the middle.
FUNCTION vec3 fisheye_ray(vec2 place, real focal_px) {
  real radius = length(place);
  real angle = radius / focal_px;
  return vec3(place * (radius > 1e-4 ? sin(angle) / radius : 1.0 / focal_px), cos(angle));
}

// Azimuth grows linearly to the right, elevation upwards.
FUNCTION vec3 equirectangular_ray(vec2 place, real focal_px) {
  vec2 angle = place / focal_px;
  return vec3(cos(angle.y) * sin(angle.x), sin(angle.y), cos(angle.y) * cos(angle.x));
}

// The inverse: where a direction appears. Perspective: multiplied by depth, for callers that divide by it.
FUNCTION vec3 perspective_place(vec3 ray, real focal_px) { return vec3(ray.x * focal_px, ray.y * focal_px, ray.z); }
FUNCTION vec2 fisheye_place(vec3 ray, real focal_px) {
  vec2 across = vec2(ray.x, ray.y);
  real size = length(across);
  return across * (size > 1e-6 ? focal_px * atan(size, ray.z) / size : focal_px);
}
FUNCTION vec2 equirectangular_place(vec3 ray, real focal_px) {
  return focal_px * vec2(atan(ray.x, ray.z), atan(ray.y, length(vec2(ray.x, ray.z))));
}
