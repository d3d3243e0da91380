#include "gles/gpu_model/projection.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace kasumi {
namespace {

glm::dvec2 distort(const std::array<double, 5>& k, const glm::dvec2& p) {
  const double r2 = glm::dot(p, p);
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return p * radial + glm::dvec2{2.0 * k[2] * p.x * p.y + k[3] * (r2 + 2.0 * p.x * p.x),
                                 k[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * k[3] * p.x * p.y};
}

// Newton's method in steps from the centre outwards, to stay on the branch that contains the centre. Empty if there is
// no solution.
std::optional<glm::dvec2> undistort(const std::array<double, 5>& k, const glm::dvec2& wanted) {
  constexpr double kStep = 1e-6;
  glm::dvec2 p{0.0};
  for (int part = 1; part <= 16; ++part) {
    const glm::dvec2 target = wanted * (part / 16.0);
    for (int i = 0; i < 20; ++i) {
      const glm::dvec2 miss = distort(k, p) - target;
      const glm::dvec2 along_x =
          (distort(k, p + glm::dvec2{kStep, 0}) - distort(k, p - glm::dvec2{kStep, 0})) / (2 * kStep);
      const glm::dvec2 along_y =
          (distort(k, p + glm::dvec2{0, kStep}) - distort(k, p - glm::dvec2{0, kStep})) / (2 * kStep);
      const glm::dmat2 slope(along_x, along_y);
      if (glm::determinant(slope) <= 1e-3) return std::nullopt;  // the lens folds here
      p -= glm::inverse(slope) * miss;
      if (glm::dot(miss, miss) < 1e-20) break;
    }
  }
  const glm::dvec2 miss = distort(k, p) - wanted;
  if (!(glm::dot(miss, miss) < 1e-12)) return std::nullopt;
  return p;
}

bool all_finite(const glm::dmat4& m) {
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(m[i / 4][i % 4])) return false;
  return true;
}

// Largest normalised radius in the picture, found along its border; empty when the distortion folds inside it.
std::optional<double> picture_radius(const SceneView& view) {
  double radius = 0.0;
  constexpr int kPoints = 16;
  for (int i = 0; i <= kPoints; ++i)
    for (const double side : {0.0, 1.0}) {
      const double t = static_cast<double>(i) / kPoints;
      for (const glm::dvec2 corner : {glm::dvec2{t, side}, glm::dvec2{side, t}}) {
        const glm::dvec2 pixel = corner * glm::dvec2(view.width, view.height) - 0.5;
        const auto p = undistort(view.distortion, (pixel - view.centre_px) / view.focal_px);
        if (!p) return std::nullopt;
        radius = std::max(radius, glm::length(*p));
      }
    }
  return radius;
}

// Slightly beyond the picture, so that triangles across its border are distorted correctly, but never past the radius
// where the polynomial turns back.
double reach_of(const std::array<double, 5>& k, double radius) {
  constexpr double kBeyond = 1.25;
  double reach = radius;
  for (double r = radius; r <= kBeyond * radius; r += 0.01 * radius) {
    const double r2 = r * r;
    if (1.0 + r2 * (3.0 * k[0] + r2 * (5.0 * k[1] + r2 * 7.0 * k[4])) < 0.1) break;
    reach = r;
  }
  return reach;
}

PixelBox cut(const Projection& projection, glm::dvec2 lowest, glm::dvec2 highest) {
  if (!(lowest.x <= highest.x) || !(lowest.y <= highest.y)) return {};
  const int margin = projection.margin_px;
  // Clamped as double, because a vertex next to the near plane may project beyond the range of int.
  const auto pixel = [&](double value, int size) {
    return static_cast<int>(std::clamp(value, double(-margin), double(size + margin)));
  };
  const SceneView& view = projection.view;
  const PixelBox box{pixel(std::floor(lowest.x) - 1.0, view.width), pixel(std::floor(lowest.y) - 1.0, view.height),
                     pixel(std::ceil(highest.x) + 2.0, view.width), pixel(std::ceil(highest.y) + 2.0, view.height)};
  return box.empty() ? PixelBox{} : box;
}

}  // namespace

Result<Projection> make_projection(const SceneView& view, const glm::dmat4& model_to_world) {
  Problems problems;
  if (view.width < 1 || view.height < 1)
    problems.add("view: {} x {} pixels: expected at least 1 x 1", view.width, view.height);
  if (!(view.focal_px.x > 0.0 && view.focal_px.y > 0.0 && std::isfinite(view.focal_px.x + view.focal_px.y)))
    problems.add("view: focal length {} x {} px: expected numbers > 0", view.focal_px.x, view.focal_px.y);
  if (!std::isfinite(view.centre_px.x + view.centre_px.y))
    problems.add("view: centre ({}, {}) px: expected finite numbers", view.centre_px.x, view.centre_px.y);
  if (!(view.near_m > 0.0 && view.far_m > view.near_m && std::isfinite(view.far_m)))
    problems.add("view: near {} m, far {} m: expected 0 < near < far", view.near_m, view.far_m);
  if (!std::ranges::all_of(view.distortion, [](double k) { return std::isfinite(k); }))
    problems.add("view: distortion: expected finite coefficients");
  if (!all_finite(view.world_to_camera) || std::abs(glm::determinant(view.world_to_camera)) < 1e-12)
    problems.add("view: world_to_camera: expected a finite, invertible matrix");
  if (!all_finite(model_to_world) || glm::determinant(model_to_world) == 0.0)
    problems.add("model_to_world: expected a finite, invertible matrix (scale > 0)");
  if (!problems.empty()) return fail(problems.fault());

  Projection projection;
  projection.view = view;
  projection.distorted = std::ranges::any_of(view.distortion, [](double k) { return k != 0.0; });
  if (projection.distorted) {
    const auto radius = picture_radius(view);
    if (!radius)
      return fail(FaultKind::bad_input,
                  "view: the distortion k1 {} k2 {} p1 {} p2 {} k3 {} folds the picture over itself before its border",
                  view.distortion[0], view.distortion[1], view.distortion[2], view.distortion[3], view.distortion[4]);
    projection.lens_reach = reach_of(view.distortion, *radius);
  }
  projection.model_to_world = model_to_world;
  projection.model_to_camera = view.world_to_camera * model_to_world;
  const glm::dmat3 turn(model_to_world);
  projection.normal_to_world = glm::transpose(glm::inverse(turn));
  projection.normal_to_world /= std::cbrt(std::abs(glm::determinant(projection.normal_to_world)));
  projection.tangent_to_world = turn / std::cbrt(std::abs(glm::determinant(turn)));
  projection.camera_to_world = glm::inverse(glm::dmat3(view.world_to_camera));
  projection.left_handed = glm::determinant(turn) < 0.0;
  projection.camera_up = glm::dvec3(view.world_to_camera[2]);
  projection.mirrored = glm::determinant(glm::dmat3(projection.model_to_camera)) < 0.0;
  return projection;
}

glm::dvec2 pixel_of(const Projection& projection, const glm::dvec3& camera) {
  glm::dvec2 p = glm::dvec2(camera) / camera.z;
  if (projection.distorted) {
    const double r = glm::length(p);
    const double inside = r > projection.lens_reach ? projection.lens_reach / r : 1.0;
    p = distort(projection.view.distortion, p * inside) / inside;
  }
  return projection.view.focal_px * p + projection.view.centre_px;
}

PixelBox box_of(const Projection& projection, std::span<const glm::vec3> positions,
                std::span<const std::uint16_t> indices) {
  glm::dvec2 lowest{1e300}, highest{-1e300};
  const auto see = [&](const glm::dvec3& camera) {
    const glm::dvec2 pixel = pixel_of(projection, camera);
    lowest = glm::min(lowest, pixel);
    highest = glm::max(highest, pixel);
  };
  const double near_m = projection.view.near_m;
  std::vector<glm::dvec3> camera;
  camera.reserve(positions.size());
  bool behind = false;
  for (const glm::vec3& position : positions) {
    camera.emplace_back(projection.model_to_camera * glm::dvec4(position, 1.0));
    if (camera.back().z >= near_m)
      see(camera.back());
    else
      behind = true;
  }
  if (behind)
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
      for (std::size_t j = 0; j < 3; ++j) {
        const glm::dvec3& a = camera[indices[i + j]];
        const glm::dvec3& b = camera[indices[i + (j + 1) % 3]];
        if ((a.z < near_m) != (b.z < near_m)) see(a + (b - a) * ((near_m - a.z) / (b.z - a.z)));
      }
  return cut(projection, lowest, highest);
}

PixelBox grown(const PixelBox& box, int px) {
  if (box.empty()) return box;
  return {box.left - px, box.top - px, box.right + px, box.bottom + px};
}

PixelBox cut_to_picture(const PixelBox& box, const SceneView& view) {
  return common(box, {0, 0, view.width, view.height});
}

PixelBox united(const PixelBox& a, const PixelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right), std::max(a.bottom, b.bottom)};
}

PixelBox common(const PixelBox& a, const PixelBox& b) {
  const PixelBox both{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
                      std::min(a.bottom, b.bottom)};
  return both.empty() ? PixelBox{} : both;
}

bool overlap(const PixelBox& a, const PixelBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

DepthRange depth_range(const Projection& projection, const ModelBounds& bounds) {
  double nearest = 1e300, farthest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at{corner & 1 ? bounds.highest.x : bounds.lowest.x,
                        corner & 2 ? bounds.highest.y : bounds.lowest.y,
                        corner & 4 ? bounds.highest.z : bounds.lowest.z};
    const double depth = (projection.model_to_camera * glm::dvec4(at, 1.0)).z;
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  DepthRange range;
  range.near_m = std::clamp(0.99 * nearest, projection.view.near_m, 0.99 * projection.view.far_m);
  range.far_m = std::clamp(1.01 * farthest, 1.001 * range.near_m, projection.view.far_m);
  return range;
}

void set_projection(const Program& program, const Projection& projection, const DepthRange& depth) {
  program.set("model_to_camera", projection.model_to_camera);
  program.set("normal_to_world", projection.normal_to_world);
  program.set("tangent_to_world", projection.tangent_to_world);
  program.set("camera_to_world", projection.camera_to_world);
  program.set("handedness", projection.left_handed ? -1.0 : 1.0);
  program.set("camera_up", projection.camera_up);
  program.set("focal_px", projection.view.focal_px);
  program.set("centre_px", projection.view.centre_px);
  program.set("near_m", depth.near_m);
  const double span = depth.far_m - depth.near_m;
  program.set("depth_to_clip",
              glm::dvec2{(depth.far_m + depth.near_m) / span, -2.0 * depth.far_m * depth.near_m / span});
  if (projection.distorted) {
    const auto& k = projection.view.distortion;
    program.set("lens_radial", glm::dvec3{k[0], k[1], k[4]});
    program.set("lens_tangential", glm::dvec2{k[2], k[3]});
    program.set("lens_reach", projection.lens_reach);
  }
}

}  // namespace kasumi
