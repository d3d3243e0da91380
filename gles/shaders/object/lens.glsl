// Brown's distortion of normalised image coordinates (OpenCV's order k1 k2 p1 p2 k3).
uniform vec3 lens_radial;        // k1 k2 k3
uniform vec2 lens_tangential;    // p1 p2
uniform float lens_reach;        // radius up to which the polynomial is valid; beyond it the scale stays constant

vec2 distorted(vec2 point) {
  float inside = min(1.0, lens_reach * inversesqrt(max(dot(point, point), 1e-12)));
  vec2 p = point * inside;
  float r2 = dot(p, p);
  float radial = 1.0 + r2 * (lens_radial.x + r2 * (lens_radial.y + r2 * lens_radial.z));
  vec2 moved = p * radial + vec2(2.0 * lens_tangential.x * p.x * p.y + lens_tangential.y * (r2 + 2.0 * p.x * p.x),
                                 lens_tangential.x * (r2 + 2.0 * p.y * p.y) + 2.0 * lens_tangential.y * p.x * p.y);
  return moved / inside;
}
