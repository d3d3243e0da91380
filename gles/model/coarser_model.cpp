#include "gles/model/coarser_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>

#include "gles/model/rare_models.hpp"

namespace kasumi {
namespace {

constexpr double kLeastShare = 0.02;  // of a texture's surface; if only less is drawn coarsely, it does not matter

// The vertices of the same key have the same number, from 0 in the order of the first of each.
template <std::size_t N>
struct Numbered {
  using Key = std::array<float, N>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::size_t hash = 0xcbf29ce484222325u;  // FNV-1a, by words
      for (const float value : key) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 0x100000001b3u;
      }
      return hash;
    }
  };
  std::vector<std::uint32_t> number;
  std::uint32_t count = 0;

  template <class KeyOf>
  Numbered(std::size_t vertices, KeyOf key_of) : number(vertices) {
    std::unordered_map<Key, std::uint32_t, Hash> known;
    for (std::size_t i = 0; i < vertices; ++i) {
      const auto [found, fresh] = known.try_emplace(key_of(i), count);
      if (fresh) ++count;
      number[i] = found->second;
    }
  }
};

// Of the triangles at each vertex.
std::vector<float> longest_edges(const ModelPart& part) {
  std::vector<float> longest(part.vertices.size(), 0.0f);
  for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    const std::array<std::uint32_t, 3> corners{part.indices[i], part.indices[i + 1], part.indices[i + 2]};
    float edge = 0.0f;
    for (std::size_t c = 0; c < 3; ++c)
      edge = std::max(edge,
                      glm::distance(part.vertices[corners[c]].position, part.vertices[corners[(c + 1) % 3]].position));
    for (const std::uint32_t corner : corners) longest[corner] = std::max(longest[corner], edge);
  }
  return longest;
}

// What faces many ways reflects less than what faces their mean: by as much as the mean is shorter than they are, but for
// the light that comes from all around.
template <std::size_t N>
void give_mean_normals(ModelPart& part, const std::vector<bool>& fine, const Numbered<N>& groups) {
  constexpr float kDirected = 0.8f;  // share of such light, in sun or under the sky
  struct Mean {
    glm::vec3 normal{0.0f}, tangent{0.0f};
    float count = 0.0f;
  };
  std::vector<Mean> means(groups.count);
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    if (!fine[i]) continue;
    Mean& mean = means[groups.number[i]];
    mean.normal += part.vertices[i].normal;
    mean.tangent += glm::vec3(part.vertices[i].tangent);
    mean.count += 1.0f;
  }
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    const Mean& mean = means[groups.number[i]];
    const float length = fine[i] ? glm::length(mean.normal) / mean.count : 0.0f;
    if (length < 0.3f) continue;
    ModelVertex& vertex = part.vertices[i];
    vertex.normal = glm::normalize(mean.normal);
    vertex.colour *= glm::vec4(glm::vec3(1.0f - kDirected * (1.0f - length)), 1.0f);
    if (glm::length(mean.tangent) > 1e-3f) vertex.tangent = glm::vec4(glm::normalize(mean.tangent), vertex.tangent.w);
  }
}

// First of the corners of flat triangles at one place, then of all in a cube of that size that face alike.
void smooth(ModelPart& part, float size) {
  const auto longest = longest_edges(part);
  const Numbered<12> places(part.vertices.size(), [&](std::size_t i) {
    const ModelVertex& v = part.vertices[i];
    return std::array<float, 12>{v.position.x, v.position.y, v.position.z, v.texture.x,   v.texture.y,   v.colour.r,
                                 v.colour.g,   v.colour.b,   v.colour.a,   v.texture_2.x, v.texture_2.y, v.tangent.w};
  });
  std::vector<float> longest_there(places.count, 0.0f);
  for (std::size_t i = 0; i < longest.size(); ++i) {
    float& there = longest_there[places.number[i]];
    there = std::max(there, longest[i]);
  }
  std::vector<bool> fine(longest.size());
  for (std::size_t i = 0; i < fine.size(); ++i) fine[i] = longest_there[places.number[i]] < size;
  give_mean_normals(part, fine, places);
  const Numbered<5> cubes(part.vertices.size(), [&](std::size_t i) {
    const ModelVertex& v = part.vertices[i];
    const glm::vec3 cube = glm::floor(v.position / size), facing = glm::abs(v.normal);
    const int axis = facing.x > facing.y && facing.x > facing.z ? 0 : facing.y > facing.z ? 1 : 2;
    const float side = static_cast<float>(2 * axis + (v.normal[axis] < 0.0f ? 1 : 0));
    return std::array<float, 5>{cube.x, cube.y, cube.z, side, v.tangent.w};
  });
  give_mean_normals(part, fine, cubes);
}

// Each vertex once, and only those that triangles use.
void weld(ModelPart& part) {
  static_assert(sizeof(ModelVertex) == 18 * sizeof(float));
  const Numbered<18> same(part.vertices.size(), [&](std::size_t i) {
    std::array<float, 18> key;
    std::memcpy(key.data(), &part.vertices[i], sizeof key);
    return key;
  });
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> place(same.count, kNone);
  std::vector<ModelVertex> kept;
  for (std::uint32_t& index : part.indices) {
    std::uint32_t& to = place[same.number[index]];
    if (to == kNone) {
      to = static_cast<std::uint32_t>(kept.size());
      kept.push_back(part.vertices[index]);
    }
    index = to;
  }
  part.vertices = std::move(kept);
}

void simplify(ModelPart& part, const RareModels& library, const Coarseness& coarseness) {
  const auto error = static_cast<float>(coarseness.error);
  if (coarseness.relief > 0.0) smooth(part, static_cast<float>(coarseness.relief));
  weld(part);
  std::vector<glm::vec3> positions;
  positions.reserve(part.vertices.size());
  for (const ModelVertex& vertex : part.vertices) positions.push_back(vertex.position);
  part.indices = library.simplified(positions, part.indices, error);
  weld(part);
}

// How finely a texture is drawn: texels for a unit of the surface, of each triangle, with its area.
struct Texels {
  std::vector<std::pair<double, double>> per_unit;

  void add(const ModelPart& part, const Image<glm::u8vec4>& picture, bool second) {
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      std::array<glm::dvec2, 3> at;
      std::array<glm::dvec3, 3> place;
      for (std::size_t c = 0; c < 3; ++c) {
        const ModelVertex& vertex = part.vertices[part.indices[i + c]];
        at[c] = glm::dvec2(second ? vertex.texture_2 : vertex.texture) * glm::dvec2(picture.width(), picture.height());
        place[c] = vertex.position;
      }
      const glm::dvec2 along = at[1] - at[0], across = at[2] - at[0];
      const double texels = std::abs(along.x * across.y - along.y * across.x);
      const double area = glm::length(glm::cross(place[1] - place[0], place[2] - place[0]));
      if (area > 0.0 && texels > 0.0) per_unit.emplace_back(std::sqrt(texels / area), area);
    }
  }

  // Where it is drawn coarsest, but for a small share; 0: it is not drawn.
  double fewest() {
    std::ranges::sort(per_unit);
    double whole = 0.0, so_far = 0.0;
    for (const auto& [texels, area] : per_unit) whole += area;
    for (const auto& [texels, area] : per_unit)
      if ((so_far += area) > kLeastShare * whole) return texels;
    return 0.0;
  }
};

void shrink_textures(std::vector<Model>& scenes, double texel) {
  std::vector<Texels> drawn(scenes.front().textures.size());
  for (const Model& scene : scenes)
    for (const ModelPart& part : scene.parts) {
      const ModelMaterial& material = scene.materials[static_cast<std::size_t>(part.material)];
      for (const MaterialMap& map : {MaterialMap{material.texture, false}, material.roughness_map, material.normal_map,
                                     material.occlusion_map, material.emission_map})
        if (map.used()) {
          const auto at = static_cast<std::size_t>(map.texture);
          drawn[at].add(part, scene.textures[at].pixels, map.second);
        }
    }
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const double fewest = drawn[i].fewest();
    const int halvings = fewest * texel > 1.0 ? static_cast<int>(std::log2(fewest * texel)) : 0;
    for (Model& scene : scenes) {
      ModelTexture& texture = scene.textures[i];
      const auto steps = std::min<std::ptrdiff_t>(halvings, std::ssize(texture.smaller));
      if (steps == 0) continue;
      texture.pixels = std::move(texture.smaller[static_cast<std::size_t>(steps - 1)]);
      texture.smaller.erase(texture.smaller.begin(), texture.smaller.begin() + steps);
    }
  }
}

}  // namespace

Result<std::vector<Model>> coarser(std::vector<Model> scenes, const Coarseness& coarseness) {
  if (coarseness.texel > 0.0 && !scenes.empty()) shrink_textures(scenes, coarseness.texel);
  if (coarseness.error <= 0.0) return scenes;
  const auto library = rare_models();
  if (!library) return fail(library.error());
  for (Model& scene : scenes) {
    for (ModelPart& part : scene.parts) simplify(part, **library, coarseness);
    std::erase_if(scene.parts, [](const ModelPart& part) { return part.indices.empty(); });
  }
  return scenes;
}

}  // namespace kasumi
