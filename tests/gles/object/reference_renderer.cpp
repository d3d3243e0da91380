#include "tests/gles/object/reference_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tests/gles/composite/reference_matte.hpp"
#include "tests/gles/object/reference_shading.hpp"
#include "tests/gles/shadow/reference_shadow.hpp"

namespace kasumi {
namespace {

struct Corner {
  glm::dvec3 camera;
  glm::dvec3 normal;   // world
  glm::dvec3 tangent;  // world
  const ModelVertex* vertex;
};

struct Triangle {
  std::array<Corner, 3> corners;
  const ModelMaterial* material;
  glm::dvec3 normal;  // of the plane, camera frame, towards the front
};

struct Hit {
  double depth;
  const Triangle* triangle;
  std::array<double, 3> weights;  // of the corners
  bool back;
};

// The shadow on the ground: what it removes of the ground's light, and the airlight's part of what is seen.
struct Shade {
  glm::dvec3 taken{0.0};
  glm::dvec3 air{0.0};
};

struct Fragment {
  glm::dvec3 n;  // rho Gamma + 1 - Gamma
  double alpha;
};

glm::dvec2 lens(const SceneView& view, glm::dvec2 p) {
  const auto& [k1, k2, p1, p2, k3] = view.distortion;
  const double r2 = p.x * p.x + p.y * p.y;
  const double radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  return {p.x * radial + 2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x),
          p.y * radial + p1 * (r2 + 2 * p.y * p.y) + 2 * p2 * p.x * p.y};
}

// The ray of a pixel, z = 1, by fixed-point iteration.
glm::dvec3 ray_of(const SceneView& view, glm::dvec2 pixel) {
  const glm::dvec2 wanted = (pixel - view.centre_px) / view.focal_px;
  glm::dvec2 p = wanted;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec2 miss = wanted - lens(view, p);
    p += miss;
    if (glm::dot(miss, miss) < 1e-28) break;
  }
  return {p, 1.0};
}

glm::dvec3 bilinear(const AirlightGrid& grid, glm::dvec2 pixel) {
  const auto index = [](double at, double first, double last, int points) {
    if (last <= first) return 0.0;
    return std::min(std::max((at - first) / (last - first), 0.0), 1.0) * (points - 1);
  };
  const double u = index(pixel.x, grid.first_px.x, grid.last_px.x, AirlightGrid::kColumns);
  const double v = index(pixel.y, grid.first_px.y, grid.last_px.y, AirlightGrid::kRows);
  glm::dvec3 sum{0.0};
  for (int row = 0; row < AirlightGrid::kRows; ++row)
    for (int column = 0; column < AirlightGrid::kColumns; ++column) {
      const double weight = std::max(0.0, 1.0 - std::abs(u - column)) * std::max(0.0, 1.0 - std::abs(v - row));
      sum += weight * grid.light[static_cast<std::size_t>(row * AirlightGrid::kColumns + column)];
    }
  return sum;
}

// Simpson's rule along the straight path.
double weighted_length(double range, double climb, double observer, double scale_height) {
  constexpr int kIntervals = 32;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * std::exp(-(observer + climb * i / kIntervals) / scale_height);
  }
  return range * sum / (3.0 * kIntervals);
}

// Light that has come down through the fog: Beer's law for the sun's rays, without the share g^2 of what droplets
// scatter, which stays near to them (delta-Eddington); for all light together the two-stream transmittance of a layer
// that absorbs nothing, 1 / (1 + 3/4 (1 - g) depth), g = .853 of fog's droplets; the difference comes from all sides
// alike.
std::pair<ObjectLight, ReferenceSky> in_fog(ObjectLight light, ReferenceSky sky, const Haze& haze, double climb) {
  if (haze.fog_per_m <= 0.0) return {light, sky};
  const double height = haze.observer_altitude_m + climb - haze.fog_base_altitude_m;
  const double depth =
      std::min(haze.fog_per_m * haze.fog_scale_height_m * std::exp(-height / haze.fog_scale_height_m), 60.0);
  const double sine = std::max(light.sun_direction.z, 0.0), whole = 1.0 / (1.0 + 0.75 * 0.147 * depth);
  const double direct = std::exp(-(1.0 - 0.853 * 0.853) * depth / std::max(sine, 0.03));
  for (glm::dvec3& coefficient : sky.radiance) coefficient *= whole;
  sky.radiance[0] += std::sqrt(4.0 * kPi) * light.sun_irradiance / kPi * sine * (whole - direct);
  light.sun_irradiance *= direct;
  return {light, sky};
}

glm::dvec3 attenuation(const Haze& haze, double range, double climb) {
  const double rayleigh = weighted_length(range, climb, haze.observer_altitude_m, haze.rayleigh_scale_height_m);
  const double mie = weighted_length(range, climb, haze.observer_altitude_m, haze.mie_scale_height_m);
  // The closed form: Simpson's 32 steps are too coarse for fog.
  const double from = (haze.observer_altitude_m - haze.fog_base_altitude_m) / haze.fog_scale_height_m;
  const double to = from + climb / haze.fog_scale_height_m;
  const double mean = std::abs(to - from) < 1e-6 ? std::exp(-from) : (std::exp(-from) - std::exp(-to)) / (to - from);
  const double fog = haze.fog_per_m > 0.0 ? haze.fog_per_m * range * mean : 0.0;
  glm::dvec3 sum{0.0};
  for (std::size_t k = 0; k < kHazeNodes; ++k)
    for (int c = 0; c < 3; ++c)
      sum[c] += haze.weight[k][c] * std::exp(-haze.rayleigh_per_m[k][c] * rayleigh - haze.mie_per_m[k][c] * mie - fog);
  return sum;
}

double srgb_light(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

int wrapped(int at, int size, TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::clamp: return std::clamp(at, 0, size - 1);
    case TextureWrap::mirrored_repeat: {
      const int turn = ((at % (2 * size)) + 2 * size) % (2 * size);
      return turn < size ? turn : 2 * size - 1 - turn;
    }
    case TextureWrap::repeat: break;
  }
  return ((at % size) + size) % size;
}

// Bilinear in linear light at full size: the test scenes magnify their textures. Colours count by their alpha: what is
// transparent has none.
glm::dvec4 texel(const ModelTexture& texture, glm::dvec2 place) {
  const int w = texture.pixels.width(), h = texture.pixels.height();
  const double x = place.x * w - 0.5, y = place.y * h - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  glm::dvec4 sum{0.0}, visible{0.0};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const glm::u8vec4 t = texture.pixels.at(wrapped(x0 + i, w, texture.wrap_s), wrapped(y0 + j, h, texture.wrap_t));
      const double weight = (i == 1 ? x - x0 : 1 - x + x0) * (j == 1 ? y - y0 : 1 - y + y0);
      const glm::dvec4 code = glm::dvec4(t) / 255.0;
      const glm::dvec4 value =
          texture.data ? code : glm::dvec4{srgb_light(code.r), srgb_light(code.g), srgb_light(code.b), code.a};
      sum += weight * value;
      visible += weight * code.a * value;
    }
  return texture.data || sum.a <= 0.0 ? sum : glm::dvec4(glm::dvec3(visible) / sum.a, sum.a);
}

class Tracer {
 public:
  explicit Tracer(const ReferenceScene& scene) : scene_(scene) {
    const glm::dmat4 to_camera = scene.view.world_to_camera * scene.model_to_world;
    const glm::dmat3 turn(scene.model_to_world);
    const glm::dmat3 normals = glm::transpose(glm::inverse(turn));
    to_world_ = glm::inverse(glm::dmat3(scene.view.world_to_camera));
    const auto add = [&](const ModelPart& part, std::vector<Triangle>& triangles) {
      for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        Triangle triangle{};
        triangle.material = &scene.model.materials[static_cast<std::size_t>(part.material)];
        for (std::size_t j = 0; j < 3; ++j) {
          const ModelVertex& vertex = part.vertices[part.indices[i + j]];
          triangle.corners[j] = {glm::dvec3(to_camera * glm::dvec4(vertex.position, 1.0)),
                                 glm::normalize(normals * glm::dvec3(vertex.normal)), turn * glm::dvec3(vertex.tangent),
                                 &vertex};
        }
        triangle.normal = glm::cross(triangle.corners[1].camera - triangle.corners[0].camera,
                                     triangle.corners[2].camera - triangle.corners[0].camera);
        triangles.push_back(triangle);
      }
    };
    for (const ModelPart& part : scene.model.parts) add(part, triangles_);
    for (const ModelPart& part : scene.model.ground) add(part, ground_);
    sky_ = reference_sky(scene.appearance.light);
    if (scene.appearance.shadows)
      shadow_.emplace(scene.model, scene.model_to_world, scene.appearance.light.sun_direction,
                      [&](const ModelMaterial& material, glm::dvec2 place) { return alpha_of(material, place); });
    up_ = glm::dvec3(scene.view.world_to_camera * glm::dvec4(0, 0, 1, 0));
  }

  // Registers every triangle with the pixels that may see it, with a margin for edges that the lens bends.
  void trace(const std::vector<glm::dvec2>& samples, ReferencePicture& picture) const {
    Image<glm::dvec4>& layer = picture.layer;
    const double share = 1.0 / static_cast<double>(samples.size());
    const int w = scene_.view.width, h = scene_.view.height;
    Image<std::vector<Hit>> hits(w, h);
    Image<glm::dvec3> rays(w, h);
    for (const glm::dvec2& offset : samples) {
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          rays.at(x, y) = ray_of(scene_.view, glm::dvec2{x, y} + offset);
          hits.at(x, y).clear();
        }
      for (const Triangle& triangle : triangles_) {
        const auto [left, top, right, bottom] = reach(triangle);
        for (int y = top; y < bottom; ++y)
          for (int x = left; x < right; ++x)
            if (const auto hit = meet(triangle, rays.at(x, y));
                hit && !is_hidden(glm::dvec2{x, y} + offset, hit->depth))
              hits.at(x, y).push_back(*hit);
      }
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          std::ranges::stable_sort(hits.at(x, y), {}, &Hit::depth);
          double clear = 1.0;
          for (const Hit& hit : hits.at(x, y)) {
            const Fragment f = shade(hit, rays.at(x, y), glm::dvec2{x, y} + offset);
            layer.at(x, y) += share * clear * f.alpha * glm::dvec4(f.n, 1.0);
            picture.taken.at(x, y) += share * clear * f.alpha;
            clear *= 1.0 - f.alpha;
            if (clear <= 0.0) break;
          }
          const Shade ground = clear > 0.0 && shadow_ ? shade_ground(rays.at(x, y)) : Shade{};
          layer.at(x, y) += share * clear * glm::dvec4(ground.taken * ground.air, ground.taken.g);
          picture.taken.at(x, y) += share * clear * ground.taken;
        }
    }
  }

 private:
  PixelBox reach(const Triangle& triangle) const {
    const SceneView& view = scene_.view;
    constexpr double kMargin = 4.0;
    glm::dvec2 low{1e9}, high{-1e9};
    for (const Corner& corner : triangle.corners) {
      if (corner.camera.z < view.near_m) return {0, 0, view.width, view.height};
      const glm::dvec2 p = view.focal_px * lens(view, glm::dvec2(corner.camera) / corner.camera.z) + view.centre_px;
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const auto cut = [](double v, int most) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(most))); };
    return {cut(low.x - kMargin, view.width), cut(low.y - kMargin, view.height), cut(high.x + kMargin, view.width),
            cut(high.y + kMargin, view.height)};
  }

  // A real surface is nearer in at least half of the pixel-sized square around the point.
  bool is_hidden(glm::dvec2 point, double depth) const {
    const Image<float>& map = scene_.depth_m;
    if (map.empty()) return false;
    const auto overlap = [](double a, double b) { return std::max(0.0, 1.0 - std::abs(a - b)); };
    const int column = static_cast<int>(std::floor(point.x)), row = static_cast<int>(std::floor(point.y));
    double hidden = 0.0;
    for (int y = row - 1; y <= row + 2; ++y)
      for (int x = column - 1; x <= column + 2; ++x) {
        const double real = map.at(std::clamp(x, 0, map.width() - 1), std::clamp(y, 0, map.height() - 1));
        if (real > 0.0 && real < depth) hidden += overlap(point.x, x) * overlap(point.y, y);
      }
    return hidden >= 0.5;
  }

  std::optional<Hit> meet(const Triangle& triangle, const glm::dvec3& ray) const {
    const auto& [a, b, c] = triangle.corners;
    const double facing = glm::dot(triangle.normal, ray);
    if (facing == 0.0 || (facing > 0.0 && !triangle.material->double_sided)) return std::nullopt;
    const double depth = glm::dot(triangle.normal, a.camera) / facing;
    if (depth < scene_.view.near_m || depth > scene_.view.far_m) return std::nullopt;
    const glm::dvec3 inside = depth * ray - a.camera;
    const double area = glm::dot(triangle.normal, triangle.normal);
    const double wb = glm::dot(triangle.normal, glm::cross(inside, c.camera - a.camera)) / area;
    const double wc = glm::dot(triangle.normal, glm::cross(b.camera - a.camera, inside)) / area;
    const double wa = 1.0 - wb - wc;
    if (wa < 0.0 || wb < 0.0 || wc < 0.0) return std::nullopt;
    return Hit{depth, &triangle, {wa, wb, wc}, facing > 0.0};
  }

  double alpha_of(const ModelMaterial& material, glm::dvec2 place) const {
    const double own = double(material.base_colour.a);
    return material.texture < 0
               ? own
               : own * texel(scene_.model.textures[static_cast<std::size_t>(material.texture)], place).a;
  }

  double sun_seen(const glm::dvec3& camera, const glm::dvec3& normal) const {
    if (!shadow_ || glm::dot(normal, scene_.appearance.light.sun_direction) <= 0.0) return 1.0;
    return shadow_->seen(glm::dvec3(glm::inverse(scene_.view.world_to_camera) * glm::dvec4(camera, 1.0)));
  }

  Shade shade_ground(const glm::dvec3& ray) const {
    std::optional<Hit> nearest;
    for (const Triangle& triangle : ground_)
      if (const auto hit = meet(triangle, ray); hit && (!nearest || hit->depth < nearest->depth)) nearest = hit;
    if (!nearest) return {};
    const auto& corners = nearest->triangle->corners;
    glm::dvec3 normal{0.0};
    for (std::size_t i = 0; i < 3; ++i) normal += nearest->weights[i] * corners[i].normal;
    normal = glm::normalize(normal);
    const glm::dvec3 at = nearest->depth * ray;
    const auto [light, around] = in_fog(scene_.appearance.light, sky_, scene_.appearance.haze, glm::dot(at, up_));
    const glm::dvec3 sun = light.sun_irradiance * std::max(glm::dot(normal, light.sun_direction), 0.0);
    const glm::dvec3 sky = reference_sky_irradiance(around, normal);
    Shade shade{(1.0 - sun_seen(at, normal)) * sun / (sun + sky), glm::dvec3{0.0}};
    if (scene_.appearance.aerial_perspective)
      shade.air = 1.0 - attenuation(scene_.appearance.haze, glm::length(at), glm::dot(at, up_));
    return shade;
  }

  Fragment shade(const Hit& hit, const glm::dvec3& ray, glm::dvec2 pixel) const {
    const auto& corners = hit.triangle->corners;
    const auto mix = [&](auto value) {
      return hit.weights[0] * value(corners[0]) + hit.weights[1] * value(corners[1]) +
             hit.weights[2] * value(corners[2]);
    };
    const ModelMaterial& material = *hit.triangle->material;
    const auto picture = [&](const MaterialMap& map) {
      return texel(scene_.model.textures[static_cast<std::size_t>(map.texture)], mix([&](const Corner& k) {
                     return glm::dvec2(map.second ? k.vertex->texture_2 : k.vertex->texture);
                   }));
    };
    ReferenceSurface surface;
    surface.colour =
        glm::dvec4(material.base_colour) * mix([](const Corner& k) { return glm::dvec4(k.vertex->colour); });
    if (material.texture >= 0) surface.colour *= picture({material.texture, false});
    double alpha = 1.0;
    if (material.alpha == ModelMaterial::Alpha::mask)
      alpha = surface.colour.a < double(material.alpha_cutoff) ? 0.0 : 1.0;
    if (material.alpha == ModelMaterial::Alpha::blend) alpha = std::clamp(surface.colour.a, 0.0, 1.0);

    surface.metallic = double(material.metallic);
    surface.roughness = double(material.roughness);
    if (material.roughness_map.used()) {
      const glm::dvec4 t = picture(material.roughness_map);
      surface.roughness *= t.g;
      surface.metallic *= t.b;
    }
    if (material.occlusion_map.used())
      surface.open_sky = 1.0 + double(material.occlusion_strength) * (picture(material.occlusion_map).r - 1.0);
    surface.emission = glm::dvec3(material.emission);
    if (material.emission_map.used()) surface.emission *= glm::dvec3(picture(material.emission_map));

    surface.normal = glm::normalize(mix([](const Corner& k) { return k.normal; }));
    if (material.normal_map.used()) {
      const glm::dvec3 n = surface.normal, t = mix([](const Corner&k) { return k.tangent; });
      const glm::dvec3 along = glm::normalize(t - n * glm::dot(n, t));
      const glm::dvec3 upwards = glm::cross(n, along) * double(corners[0].vertex->tangent.w);
      const glm::dvec3 tilt = 2.0 * glm::dvec3(picture(material.normal_map)) - 1.0;
      const double scale = double(material.normal_scale), size = std::min(glm::length(tilt), 1.0);
      surface.normal = glm::normalize(scale * tilt.x * along + scale * tilt.y * upwards + tilt.z * n);
      // Toksvig: normals that differ within a texel make it rougher.
      const double spread = std::max((1.0 - size) / size - 0.006, 0.0) * scale * scale;
      surface.roughness = std::pow(std::min(std::pow(surface.roughness, 4) + 2.0 * spread, 1.0), 0.25);
    }
    if (hit.back) surface.normal = -surface.normal;
    surface.sun_seen = sun_seen(hit.depth * ray, surface.normal);

    const ObjectAppearance& look = scene_.appearance;
    const auto [light, sky] = look.aerial_perspective
                                  ? in_fog(look.light, sky_, look.haze, glm::dot(hit.depth * ray, up_))
                                  : std::pair(look.light, sky_);
    const glm::dvec3 radiance = reference_radiance(material, surface, light, sky, -glm::normalize(to_world_ * ray));
    const glm::dvec3 rho = radiance / bilinear(look.horizon, pixel);
    if (!look.aerial_perspective) return {rho, alpha};
    const glm::dvec3 at = hit.depth * ray;
    const glm::dvec3 passed = attenuation(look.haze, glm::length(at), glm::dot(at, up_));
    return {rho * passed + 1.0 - passed, alpha};
  }

  const ReferenceScene& scene_;
  std::vector<Triangle> triangles_, ground_;
  std::optional<ReferenceShadow> shadow_;
  ReferenceSky sky_;
  glm::dvec3 up_{};
  glm::dmat3 to_world_{1.0};
};

}  // namespace

std::vector<glm::dvec2> turned_lattice() {
  std::vector<glm::dvec2> points;
  for (int a = -4; a <= 4; ++a)
    for (int b = -4; b <= 4; ++b) {
      const glm::dvec2 point{(4.0 * a - b) / 17.0, (a + 4.0 * b) / 17.0};
      if (std::abs(point.x) < 0.5 && std::abs(point.y) < 0.5) points.push_back(point);
    }
  return points;
}

std::vector<glm::dvec2> upright_grid(int side) {
  std::vector<glm::dvec2> points;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) points.emplace_back((x + 0.5) / side - 0.5, (y + 0.5) / side - 0.5);
  return points;
}

std::vector<glm::dvec2> pixel_centre() {
  return {glm::dvec2{0.0, 0.0}};
}

double reference_light(const ResponseCurve& response, int channel, double code) {
  switch (response.kind) {
    case ResponseCurve::Kind::linear: return code;
    case ResponseCurve::Kind::srgb: return srgb_light(code);
    case ResponseCurve::Kind::table: break;
  }
  const auto& table = response.light[static_cast<std::size_t>(channel)];
  const double place = code * static_cast<double>(table.size() - 1);
  const auto entry = std::min(static_cast<std::size_t>(place), table.size() - 2);
  return table[entry] + (place - static_cast<double>(entry)) * (table[entry + 1] - table[entry]);
}

double reference_code(const ResponseCurve& response, int channel, double light) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 30; ++i) {  // to a billionth
    const double middle = 0.5 * (low + high);
    (reference_light(response, channel, middle) < light ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

ReferencePicture render_reference(const ReferenceScene& scene, const Image<Rgb8>& camera,
                                  const std::vector<glm::dvec2>& samples) {
  const int w = scene.view.width, h = scene.view.height;
  ReferencePicture picture{Image<glm::dvec3>(w, h), Image<glm::dvec4>(w, h, glm::dvec4{0.0}),
                           Image<glm::dvec3>(w, h, glm::dvec3{0.0})};
  Tracer(scene).trace(samples, picture);
  if (!scene.mask.empty())
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        picture.layer.at(x, y) *= scene.mask.at(x, y) / 255.0;
        picture.taken.at(x, y) *= scene.mask.at(x, y) / 255.0;
      }
  return before_picture(std::move(picture), scene, camera);
}

ReferencePicture before_picture(ReferencePicture picture, const ReferenceScene& scene, const Image<Rgb8>& camera) {
  for (int y = 0; y < scene.view.height; ++y)
    for (int x = 0; x < scene.view.width; ++x) {
      const glm::dvec4& object = picture.layer.at(x, y);
      const glm::dvec3& taken = picture.taken.at(x, y);
      const glm::dvec3 airlight = bilinear(scene.measured, {x, y});
      const glm::dvec3 unsaturated = airlight * glm::dvec3(object);
      const double grey = glm::dot(unsaturated, glm::dvec3{0.2126, 0.7152, 0.0722});
      const glm::dvec3 own = glm::max(grey + scene.measured.saturation * (unsaturated - grey), glm::dvec3{0.0});
      const double by_mask = scene.mask.empty() ? 1.0 : scene.mask.at(x, y) / 255.0;
      std::optional<ReferenceMatte> matte;
      if (!scene.by_mask && by_mask > 0.0 && by_mask < 1.0 && object.a > 0.0)
        matte = reference_matte(scene, camera, x, y);
      for (int c = 0; c < 3; ++c) {
        const double code = camera.at(x, y)[c] / 255.0;
        double light = reference_light(scene.response, c, code) * (1.0 - taken[c]) + own[c];
        if (matte)  // the layer is the mask's share of the whole
          light = reference_light(scene.response, c, code) +
                  (own[c] * matte->open_share - taken[c] * matte->behind[c]) / by_mask;
        picture.encoded.at(x, y)[c] = 255.0 * (object.a > 0.0 ? reference_code(scene.response, c, light) : code);
      }
    }
  return picture;
}

double psnr(const Image<Rgb8>& picture, const ReferencePicture& reference) {
  double compared = 0.0, all = 0.0, compared_count = 0.0, all_count = 0.0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const glm::dvec3 shown(picture.at(x, y)), miss = shown - reference.encoded.at(x, y);
      const double square = glm::dot(miss, miss) / 3.0;
      all += square;
      all_count += 1.0;
      if (reference.layer.at(x, y).a <= 0.0 && shown == glm::round(reference.encoded.at(x, y))) continue;
      compared += square;
      compared_count += 1.0;
    }
  const double mean = compared_count > 0.0 ? compared / compared_count : all / all_count;
  return 10.0 * std::log10(255.0 * 255.0 / std::max(mean, 1e-12));
}

}  // namespace kasumi
