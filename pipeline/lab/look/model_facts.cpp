#include "pipeline/lab/look/model_facts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace kasumi {

namespace {

constexpr double kLargest_m = 300.0;
constexpr double kFarthest_m = 1000.0;  // from its origin; a site is smaller

struct Faces {
  glm::dvec3 sum{0.0};    // of all triangles: area times normal
  double area = 0.0;      // m^2
  glm::dvec3 lying{0.0};  // area within the lowest fiftieth of each axis, facing along it
};

Faces faces_of(const Model& model) {
  Faces faces;
  const auto box = model.bounds();
  const glm::dvec3 lowest(box.lowest), size = glm::dvec3(box.highest) - lowest;
  for (const ModelPart& part : model.parts)
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const auto at = [&](std::size_t c) { return glm::dvec3(part.vertices[part.indices[i + c]].position); };
      const glm::dvec3 across = 0.5 * glm::cross(at(1) - at(0), at(2) - at(0));
      const double area = glm::length(across);
      faces.sum += across;
      faces.area += area;
      const glm::dvec3 middle = (at(0) + at(1) + at(2)) / 3.0;
      for (int axis = 0; axis < 3; ++axis)
        if (std::abs(across[axis]) > 0.97 * area && middle[axis] < lowest[axis] + 0.02 * size[axis])
          faces.lying[axis] += area;
    }
  return faces;
}

std::string joined(const std::vector<std::string>& words) {
  std::string line;
  for (const auto& word : words) line += (line.empty() ? "" : ", ") + word;
  return line;
}

std::string bytes_text(std::size_t bytes) {
  return bytes < 1'000'000 ? fmt::format("{:.0f} kB", static_cast<double>(bytes) / 1e3)
                           : fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string textures_text(const Model& model) {
  if (model.textures.empty()) return "no textures";
  int largest = 0;
  std::size_t texels = 0;
  for (const auto& texture : model.textures) {
    largest = std::max({largest, texture.pixels.width(), texture.pixels.height()});
    texels += texture.pixels.elements().size();
  }
  return fmt::format("{} textures of up to {} texels a side, {} on the GPU", model.textures.size(), largest,
                     bytes_text(texels * 16 / 3));
}

std::string ground_text(const Model& model) {
  if (model.ground.empty())
    return "ground: none in the model, so nothing receives its shadow (docs/models.md, kasumi_ground)";
  const auto whole = model.bounds_with_ground(), own = model.bounds();
  std::size_t triangles = 0;
  for (const ModelPart& part : model.ground) triangles += part.indices.size() / 3;
  return fmt::format("ground: {} triangles, {:.0f} m across; the model's foot is at {:.2f} m", triangles,
                     whole.highest.x - whole.lowest.x, own.lowest.y);
}

}  // namespace

bool seems_z_up(const Model& model) {
  const Faces faces = faces_of(model);
  if (faces.area <= 0.0) return false;
  const auto box = model.bounds();
  const glm::dvec3 lowest(box.lowest), size = glm::dvec3(box.highest) - lowest;
  if (size.z < 0.1 * std::max(size.x, size.y)) return false;  // a facade or a panel, which stands
  const auto stands = [&](int axis) { return std::abs(lowest[axis]) < 0.1 * size[axis]; };
  const auto centred = [&](int axis, double within) {
    return std::abs(lowest[axis] + 0.5 * size[axis]) < within * size[axis];
  };
  // By how much more the one axis looks like the vertical than the other, in signs.
  const auto signs = [&](int axis, int other) {
    int found = 0;
    found += stands(axis) && !centred(axis, 0.2);
    found += centred(other, 0.15);
    found += faces.sum[axis] > 0.1 * faces.area && faces.sum[axis] > 2.0 * std::abs(faces.sum[other]);
    found += faces.lying[axis] > 0.05 * size.x * size[other] && faces.lying[axis] > 3.0 * faces.lying[other];
    return found;
  };
  constexpr int kY = 1, kZ = 2;
  return signs(kZ, kY) - signs(kY, kZ) >= 2;
}

ModelFacts facts_of(const Model& model, UpAxis up) {
  ModelFacts facts;
  const auto box = model.bounds();
  const glm::dvec3 size(box.highest - box.lowest);
  const bool z = up == UpAxis::z;
  const double height = z ? size.z : size.y, deep = z ? size.y : size.z;
  facts.lines.push_back(
      fmt::format("size: {:.2f} m wide (x), {:.2f} m deep, {:.2f} m high ({} up); its foot at {:.2f} m", size.x, deep,
                  height, z ? "z" : "y", z ? box.lowest.z : box.lowest.y));
  facts.lines.push_back(fmt::format("{} triangles, {} materials, {}", model.triangle_count(),
                                    model.materials.size() - 1, textures_text(model)));
  facts.lines.push_back("extensions: " + (model.extensions.empty() ? "none" : joined(model.extensions)));
  if (model.scenes.size() > 1) facts.lines.push_back(fmt::format("scenes: {}", joined(model.scenes)));
  facts.lines.push_back(ground_text(model));
  if (model.notes.empty()) facts.lines.emplace_back("nothing was left out");
  for (const auto& note : model.notes) facts.lines.push_back("left out or changed: " + note);

  if (!z && seems_z_up(model))
    facts.doubts.emplace_back(
        "its z seems to point up: if it lies on its back in the picture, [object] up = \"z\" sets it upright");
  const double largest = std::max({size.x, size.y, size.z});
  if (largest > kLargest_m)
    facts.doubts.push_back(
        fmt::format("{:.0f} m across: larger than nearly all buildings. glTF's unit is the metre; if its is the "
                    "centimetre, [object] "
                    "scale = 0.01, the millimetre 0.001, the foot 0.3048",
                    largest));
  const double away = glm::length(glm::dvec3(box.lowest + box.highest) / 2.0);
  if (away > kFarthest_m && away > 10.0 * largest)
    facts.doubts.push_back(
        fmt::format("its middle lies {:.1f} km from its origin, as a map's or the globe's coordinates have it: numbers "
                    "so large are exact to {:.2g} m. Move it to the origin first",
                    away / 1000.0, away * double{std::numeric_limits<float>::epsilon()} / 2.0));
  if (largest < 0.5)
    facts.doubts.push_back(
        fmt::format("{:.3f} m across: smaller than any building. [object] scale makes it larger", largest));
  return facts;
}

}  // namespace kasumi
