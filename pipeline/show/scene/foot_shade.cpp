#include "pipeline/show/scene/foot_shade.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr double kReach = 2.5;        // heights of the object: beyond, a long wall hides less than 4 % of the sky
constexpr int kMostPoints = 192;      // along a side
constexpr double kLeastStep_m = 0.1;  // no finer: the shade of a whole building is smooth
constexpr int kMapSide = 256;         // texels
// Of a shade within .004 of the closed form (docs/physics.md 6); in steps, so that the drawing goes on meanwhile.
constexpr int kFewestDirections = 64, kDirectionsPerStep = 8;
constexpr std::size_t kTrianglesInAll = 20'000'000;  // drawn, from all directions together
constexpr float kNothing = -1e30f;                   // a height below all ground

struct AcrossDirection {  // across a direction
  glm::vec3 right, up;
};
AcrossDirection across_sky(const glm::vec3& direction) {
  const glm::vec3 right =
      glm::normalize(glm::cross(std::abs(direction.z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0), direction));
  return {right, glm::cross(direction, right)};
}

// Direction `index` of `count` over the upper hemisphere, as dense as the cosine to the vertical: a spiral.
glm::vec3 sky_direction(int index, int count) {
  constexpr double kGolden = 2.399963229728653;  // pi (3 - sqrt(5)): the golden angle
  const double level2 = (index + 0.5) / count, turn = kGolden * index;
  const double level = std::sqrt(level2);
  return glm::vec3(level * std::cos(turn), level * std::sin(turn), std::sqrt(1.0 - level2));
}

// Leaves of the places first .. last those at which `at_zero + place * step` is not negative.
void keep_where_not_negative(float at_zero, float step, float& first, float& last) {
  if (step > 0.0f)
    first = std::max(first, -at_zero / step);
  else if (step < 0.0f)
    last = std::min(last, -at_zero / step);
  else if (at_zero < 0.0f)
    last = -1.0f;
}

// Calls visit(x, y, value) for each whole x and y within a triangle, value being linear between its corners' z.
template <class Visit>
void fill(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, int width, int height, const Visit& visit) {
  const glm::vec3 ab = b - a, ac = c - a;
  const float area = ab.x * ac.y - ab.y * ac.x;
  if (std::abs(area) < 1e-9f) return;
  const float of_b_step = ac.y / area, of_c_step = -ab.y / area;  // the corners' weights, along a row
  const int top = static_cast<int>(std::ceil(std::clamp(std::min({a.y, b.y, c.y}), 0.0f, 1e6f)));
  const int bottom =
      static_cast<int>(std::floor(std::clamp(std::max({a.y, b.y, c.y}), -1.0f, static_cast<float>(height - 1))));
  for (int y = top; y <= bottom; ++y) {
    const float down = static_cast<float>(y) - a.y;
    const float of_b = (-a.x * ac.y - down * ac.x) / area, of_c = (ab.x * down + a.x * ab.y) / area;
    float first = 0.0f, last = static_cast<float>(width - 1);
    keep_where_not_negative(of_b, of_b_step, first, last);
    keep_where_not_negative(of_c, of_c_step, first, last);
    keep_where_not_negative(1.0f - of_b - of_c, -of_b_step - of_c_step, first, last);
    for (float x = std::ceil(first); x <= last; ++x)  // either may lie too far outside for an int
      visit(static_cast<int>(x), y, a.z + (of_b + x * of_b_step) * ab.z + (of_c + x * of_c_step) * ac.z);
  }
}

template <class Use>
void each_triangle(const ModelPart& part, const glm::dmat4& to_world, const Use& use) {
  const auto at = [&](std::size_t i) {
    return glm::vec3(to_world * glm::dvec4(part.vertices[part.indices[i]].position, 1.0));
  };
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) use(at(i), at(i + 1), at(i + 2));
}

}  // namespace

FootShadeWork::FootShadeWork(const Model& model, const glm::dmat4& to_world) {
  if (model.ground.empty() || model.triangle_count() > kMostTriangles) return;
  for (const ModelPart& part : model.parts) {
    if (model.materials[static_cast<std::size_t>(part.material)].alpha == ModelMaterial::Alpha::blend) continue;
    each_triangle(part, to_world, [&](const auto&... corner) { (corners_.push_back(corner), ...); });
  }
  if (corners_.empty()) return;
  lay_ground(model, to_world);
  const int directions = std::clamp(static_cast<int>(kTrianglesInAll / (corners_.size() / 3)), kFewestDirections,
                                    GroundExposure::kMostDirections);
  for (int i = 0; i < directions; ++i) made_.directions_.push_back(sky_direction(i, directions));
}

void FootShadeWork::lay_ground(const Model& model, const glm::dmat4& to_world) {
  glm::dvec3 lowest(1e30), highest(-1e30);
  for (const glm::vec3& corner : corners_) {
    lowest = glm::min(lowest, glm::dvec3(corner));
    highest = glm::max(highest, glm::dvec3(corner));
  }
  const double reach = kReach * (highest.z - lowest.z);
  const glm::dvec2 span = glm::dvec2(highest - lowest) + 2.0 * reach;
  const double step = std::max(std::max(span.x, span.y) / (kMostPoints - 1), kLeastStep_m);
  made_.first_m_ = glm::dvec2(lowest) - reach;
  made_.step_m_ = glm::dvec2(step);
  const glm::ivec2 points = glm::ivec2(span / step) + 1;
  made_.ground_ = Image<GroundExposure::Ground>(points.x, points.y);
  const auto on_grid = [&](const glm::vec3& p) {
    return glm::vec3(glm::vec2((glm::dvec2(p) - made_.first_m_) / step), p.z);
  };
  for (const ModelPart& part : model.ground)
    each_triangle(part, to_world, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
      glm::vec3 normal = glm::cross(b - a, c - a);
      if (glm::length(normal) < 1e-9f) return;
      normal = glm::normalize(normal);
      if (normal.z < 0.0f) normal = -normal;
      fill(on_grid(a), on_grid(b), on_grid(c), points.x, points.y, [&](int x, int y, float up_m) {
        auto& here = made_.ground_.at(x, y);
        if (here.normal == glm::vec3(0.0f) || up_m > here.up_m) here = {normal, up_m, {}};
      });
    });
}

void FootShadeWork::look_from(std::size_t number) {
  const glm::vec3 sky = made_.directions_[number];
  const AcrossDirection plane = across_sky(sky);
  const auto seen = [&](const glm::vec3& p) {
    return glm::vec3(glm::dot(p, plane.right), glm::dot(p, plane.up), glm::dot(p, sky));
  };
  glm::vec2 lowest(1e30f), highest(-1e30f);
  std::vector<glm::vec3> projected(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    projected[i] = seen(corners_[i]);
    lowest = glm::min(lowest, glm::vec2(projected[i]));
    highest = glm::max(highest, glm::vec2(projected[i]));
  }
  const glm::vec2 texels = (kMapSide - 1.0f) / glm::max(highest - lowest, glm::vec2(1e-3f));
  const auto on_map = [&](const glm::vec3& p) { return glm::vec3((glm::vec2(p) - lowest) * texels, p.z); };
  Image<float> reach(kMapSide, kMapSide, kNothing);
  for (std::size_t i = 0; i + 2 < projected.size(); i += 3)
    fill(on_map(projected[i]), on_map(projected[i + 1]), on_map(projected[i + 2]), kMapSide, kMapSide,
         [&](int x, int y, float depth) { reach.at(x, y) = std::max(reach.at(x, y), depth); });
  const float in_front = 0.02f;  // m: ground that touches the object is not hidden by what lies in it
  for (int y = 0; y < made_.ground_.height(); ++y)
    for (int x = 0; x < made_.ground_.width(); ++x) {
      auto& here = made_.ground_.at(x, y);
      if (here.normal == glm::vec3(0.0f)) continue;
      const glm::vec2 at(made_.first_m_ + made_.step_m_ * glm::dvec2(x, y));
      const glm::vec3 p = on_map(seen(glm::vec3(at, here.up_m)));
      const int column = static_cast<int>(std::lround(p.x)), row = static_cast<int>(std::lround(p.y));
      here.hidden[number] = reach.contains(column, row) && reach.at(column, row) > p.z + in_front;
    }
}

bool FootShadeWork::step() {
  for (int i = 0; i < kDirectionsPerStep && done_ < made_.directions_.size(); ++i) look_from(done_++);
  return done_ == made_.directions_.size();
}

std::shared_ptr<const GroundExposure> FootShadeWork::take() {
  corners_ = {};
  if (made_.directions_.empty()) return nullptr;
  return std::make_shared<const GroundExposure>(std::move(made_));
}

FootShade GroundExposure::under(const LightAround& around) const {
  // As the directions are as dense as the cosine to the vertical, each has the weight of its radiance times the cosine to
  // the normal over that to the vertical.
  std::vector<float> radiance;
  for (const glm::vec3& direction : directions_) {
    const glm::dvec2 at = 0.5 * (place_on_map(glm::dvec3(direction)) + 1.0) * (LightAround::kSize - 1.0);
    const auto texel = glm::clamp(glm::ivec2(glm::round(at)), 0, LightAround::kSize - 1);
    radiance.push_back(around.radiance.at(texel.x, texel.y).g / direction.z);
  }
  FootShade shade{first_m_, step_m_, Image<float>(ground_.width(), ground_.height(), 1.0f)};
  for (int y = 1; y + 1 < ground_.height(); ++y)  // the edges hold 1
    for (int x = 1; x + 1 < ground_.width(); ++x) {
      const Ground& here = ground_.at(x, y);
      if (here.hidden.none()) continue;
      float all = 0.0f, lost = 0.0f;
      for (std::size_t i = 0; i < directions_.size(); ++i) {
        const float light = radiance[i] * std::max(glm::dot(here.normal, directions_[i]), 0.0f);
        all += light;
        if (here.hidden[i]) lost += light;
      }
      if (all > 0.0f) shade.sky_seen.at(x, y) = 1.0f - lost / all;
    }
  return shade;
}

std::shared_ptr<const GroundExposure> sky_over_ground(const Model& model, const glm::dmat4& model_to_world) {
  FootShadeWork work(model, model_to_world);
  while (!work.step()) {
  }
  return work.take();
}

}  // namespace kasumi
