#include "gles/gpu_model/gpu_model.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMaxTriangles = 2048;  // per chunk: few enough for 16-bit indices

}  // namespace

// Renumbers the vertices of a chunk's triangles from 0.
class GpuModel::Cutter {
 public:
  explicit Cutter(std::size_t vertices) : places_(vertices, kNone) {}

  // Whether the vertex is new to this chunk.
  bool add(std::uint32_t vertex) {
    const bool is_new = places_[vertex] == kNone;
    if (is_new) {
      places_[vertex] = static_cast<std::uint16_t>(met_.size());
      met_.push_back(vertex);
    }
    indices_.push_back(places_[vertex]);
    return is_new;
  }
  std::vector<std::uint16_t> take() {
    for (const std::uint32_t vertex : met_) places_[vertex] = kNone;
    met_.clear();
    return std::exchange(indices_, {});
  }

 private:
  static constexpr std::uint16_t kNone = std::numeric_limits<std::uint16_t>::max();
  static_assert(3 * kMaxTriangles < kNone);
  std::vector<std::uint16_t> places_;
  std::vector<std::uint32_t> met_;
  std::vector<std::uint16_t> indices_;
};

// Splits in space, across the longest axis.
std::pair<std::span<GpuModel::Triangle>, std::span<GpuModel::Triangle>> GpuModel::halved(
    std::span<Triangle> triangles) {
  glm::vec3 lowest = triangles.front().centre, highest = lowest;
  for (const Triangle& triangle : triangles) {
    lowest = glm::min(lowest, triangle.centre);
    highest = glm::max(highest, triangle.centre);
  }
  const glm::vec3 extent = highest - lowest;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto middle = triangles.begin() + static_cast<std::ptrdiff_t>(triangles.size() / 2);
  std::ranges::nth_element(triangles, middle, {}, [axis](const Triangle& triangle) {
    return std::tuple(triangle.centre[axis], triangle.part, triangle.first_index);
  });
  return {{triangles.begin(), middle}, {middle, triangles.end()}};
}

GpuModel::Chunk GpuModel::make_chunk(int material, std::span<const GpuVertex> vertices,
                                     std::vector<std::uint16_t> index_list) {
  Chunk chunk;
  chunk.material = material;
  for (const GpuVertex& vertex : vertices) chunk.positions.push_back(vertex.position);
  chunk.index_list = std::move(index_list);
  chunk.vertices = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, chunk.vertices.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(), GL_STATIC_DRAW);
  chunk.indices = make_buffer();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(chunk.index_list.size() * sizeof(std::uint16_t)),
               chunk.index_list.data(), GL_STATIC_DRAW);
  return chunk;
}

Result<GpuModel> GpuModel::upload(const Model& model, const GlInfo& info, bool force_encoded_textures,
                                  std::vector<std::string>& notes) {
  if (auto sound = check(model); !sound) return fail(sound.error());
  GpuModel made;
  made.materials_ = model.materials;
  made.bounds_ = model.bounds();
  made.bounds_with_ground_ = model.bounds_with_ground();
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    auto uploaded =
        kasumi::upload(model.textures[i], cutoff_of(model, static_cast<int>(i)), info, force_encoded_textures, notes);
    if (!uploaded) return fail(uploaded.error());
    made.bytes_ += uploaded->bytes;
    made.textures_.push_back(std::move(*uploaded));
  }
  made.add(model, model.parts, made.solid_);
  made.add(model, model.ground, made.ground_);
  made.add_see_through(model);
  if (auto uploaded = check_gl("uploading the model"); !uploaded) return fail(uploaded.error());
  return made;
}

// Parts with the same material are merged, because files have hundreds of parts and each draw call costs time. The
// result is split in space, so that a tile of the picture draws only nearby chunks.
void GpuModel::add(const Model& model, const std::vector<ModelPart>& parts, std::vector<Chunk>& chunks) {
  const bool all = &parts == &model.ground;  // the ground is never see-through
  std::vector<std::vector<Triangle>> by_material(model.materials.size());
  std::vector<std::uint32_t> first_vertex;  // of each part, if all parts were concatenated
  std::size_t vertices = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ModelPart& part = parts[p];
    first_vertex.push_back(static_cast<std::uint32_t>(vertices));
    vertices += part.vertices.size();
    const auto material = static_cast<std::size_t>(part.material);
    if (!all && model.materials[material].alpha == ModelMaterial::Alpha::blend) continue;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const auto at = [&](std::size_t j) { return part.vertices[part.indices[i + j]].position; };
      by_material[material].push_back(
          {static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(i), (at(0) + at(1) + at(2)) / 3.0f});
    }
  }
  Cutter cutter(vertices);
  const std::function<void(int, std::span<Triangle>)> add_split = [&](int material, std::span<Triangle> triangles) {
    if (triangles.empty()) return;
    if (triangles.size() <= kMaxTriangles) {
      std::vector<GpuVertex> corners;
      for (const Triangle& triangle : triangles) {
        const ModelPart& part = parts[triangle.part];
        for (std::uint32_t j = 0; j < 3; ++j) {
          const std::uint32_t index = part.indices[triangle.first_index + j];
          if (cutter.add(first_vertex[triangle.part] + index)) corners.emplace_back(part.vertices[index]);
        }
      }
      bytes_ += corners.size() * sizeof(GpuVertex) + triangles.size() * 3 * sizeof(std::uint16_t);
      chunks.push_back(make_chunk(material, corners, cutter.take()));
      return;
    }
    const auto half = halved(triangles);
    add_split(material, half.first);
    add_split(material, half.second);
  };
  for (std::size_t material = 0; material < by_material.size(); ++material) {
    add_split(static_cast<int>(material), by_material[material]);
    by_material[material] = {};
  }
}

void GpuModel::add_see_through(const Model& model) {
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    const ModelPart& part = model.parts[p];
    if (materials_[static_cast<std::size_t>(part.material)].alpha != ModelMaterial::Alpha::blend) continue;
    const auto first = static_cast<std::uint32_t>(see_through_.vertices.size());
    for (const ModelVertex& vertex : part.vertices) see_through_.vertices.emplace_back(vertex);
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3)
      see_through_.triangles.push_back(
          {part.material,
           static_cast<std::uint32_t>(p),
           {first + part.indices[i], first + part.indices[i + 1], first + part.indices[i + 2]}});
  }
  bytes_ +=
      see_through_.vertices.size() * sizeof(GpuVertex) + see_through_.triangles.size() * 3 * sizeof(std::uint16_t);
}

// Sorts all triangles of all parts together. If materials would then alternate too often, sorts the parts and the
// triangles within each.
void GpuModel::sort_see_through(const Projection& projection) {
  constexpr std::size_t kMaxMaterialChanges = 1000;
  auto& triangles = see_through_.triangles;
  std::map<std::uint32_t, std::pair<double, double>> parts;  // sum of depths, count
  for (SeeThroughTriangle& triangle : triangles) {
    triangle.depth_m = 0.0;
    for (const std::uint32_t corner : triangle.corners)
      triangle.depth_m +=
          (projection.model_to_camera * glm::dvec4(see_through_.vertices[corner].position, 1.0)).z / 3.0;
    auto& [sum, count] = parts[triangle.part];
    sum += triangle.depth_m;
    count += 1.0;
  }
  std::ranges::stable_sort(triangles, std::greater<>(), &SeeThroughTriangle::depth_m);
  std::size_t changes = 0;
  for (std::size_t i = 1; i < triangles.size(); ++i)
    changes += triangles[i].material != triangles[i - 1].material ? 1 : 0;
  if (changes > kMaxMaterialChanges)
    std::ranges::stable_sort(triangles, std::greater<>(), [&](const SeeThroughTriangle& triangle) {
      const auto& [sum, count] = parts[triangle.part];
      return std::tuple(sum / count, triangle.part);
    });

  see_through_.chunks.clear();
  Cutter cutter(see_through_.vertices.size());
  std::vector<GpuVertex> corners;
  for (std::size_t i = 0; i < triangles.size();) {
    const std::size_t first = i;
    for (; i < triangles.size() && i - first < kMaxTriangles && triangles[i].material == triangles[first].material; ++i)
      for (const std::uint32_t corner : triangles[i].corners)
        if (cutter.add(corner)) corners.push_back(see_through_.vertices[corner]);
    see_through_.chunks.push_back(make_chunk(triangles[first].material, corners, cutter.take()));
    corners.clear();
  }
}

PixelBox GpuModel::look_from(const Projection& projection) {
  sort_see_through(projection);
  PixelBox all;
  for (auto* chunks : {&solid_, &see_through_.chunks, &ground_})
    for (Chunk& chunk : *chunks) {
      chunk.box = box_of(projection, chunk.positions, chunk.index_list);
      all = united(all, chunk.box);
    }
  return all;
}

void GpuModel::draw_chunk(const Chunk& chunk) const {
  glBindBuffer(GL_ARRAY_BUFFER, chunk.vertices.name());
  for (const VertexAttribute& attribute : kVertexAttributes)
    glVertexAttribPointer(attribute.place, attribute.components, attribute.type,
                          attribute.type == GL_FLOAT ? GL_FALSE : GL_TRUE, sizeof(GpuVertex),
                          reinterpret_cast<const void*>(attribute.offset));
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(chunk.index_list.size()), GL_UNSIGNED_SHORT, nullptr);
}

const std::vector<GpuModel::Chunk>& GpuModel::chunks_of(Which which) const {
  switch (which) {
    case Which::solid: return solid_;
    case Which::blended: return see_through_.chunks;
    case Which::ground: return ground_;
  }
  return solid_;
}

Result<> GpuModel::draw(Which which, Programs& programs, const Defines& variant, const SurfaceUnits& units,
                        const PixelBox& window, const std::function<void(const Program&)>& set_uniforms) const {
  const bool blended = which == Which::blended, ground = which == Which::ground;
  if (blended) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  }
  begin_chunks(!blended);
  // The object is always drawn over its ground, so that its parts below ground stay visible, as without ground.
  if (has_ground()) glDepthRangef(ground ? 0.75f : 0.0f, ground ? 1.0f : 0.75f);
  const Program* in_use = nullptr;
  int material_in_use = -1;
  for (const Chunk& chunk : chunks_of(which)) {
    if (chunk.box.empty() || (!window.empty() && !overlap(chunk.box, window))) continue;
    if (chunk.material != material_in_use) {
      material_in_use = chunk.material;
      const ModelMaterial& material = materials_[static_cast<std::size_t>(chunk.material)];
      Defines defines = ground ? Defines{} : defines_of(material, textures_, units);
      defines.insert(variant.begin(), variant.end());
      const auto program = programs.find(ground ? ProgramKind::ground : ProgramKind::object, defines);
      if (!program) return fail(program.error());
      if (*program != in_use) {
        in_use = *program;
        in_use->use();
        set_uniforms(*in_use);
      }
      bind_material(*in_use, material, textures_, ground ? SurfaceUnits{} : units);
      if (material.double_sided || ground)
        glDisable(GL_CULL_FACE);
      else
        glEnable(GL_CULL_FACE);
    }
    draw_chunk(chunk);
  }
  end_chunks();
  return check_gl("drawing the model");
}

Result<> GpuModel::draw_shadow(Programs& programs, const Defines& variant,
                               const std::function<void(const Program&)>& set_uniforms) const {
  const SurfaceUnits units{.base = kSurfaceUnit};
  begin_chunks(true);
  const Program* in_use = nullptr;
  for (const Chunk& chunk : solid_) {
    const ModelMaterial& material = materials_[static_cast<std::size_t>(chunk.material)];
    Defines defines = variant;
    if (material.alpha == ModelMaterial::Alpha::mask) {
      defines.insert("ALPHA_TEST");
      if (material.texture >= 0) defines.insert("BASE_MAP v_texture");
    }
    const auto program = programs.find(ProgramKind::sun_map, defines);
    if (!program) return fail(program.error());
    if (*program != in_use) {
      in_use = *program;
      in_use->use();
      set_uniforms(*in_use);
    }
    if (material.alpha == ModelMaterial::Alpha::mask) bind_material(*in_use, material, textures_, units);
    draw_chunk(chunk);
  }
  end_chunks();
  return check_gl("drawing shadow casters");
}

void GpuModel::begin_chunks(bool write_depth) {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(write_depth ? GL_TRUE : GL_FALSE);
  for (const VertexAttribute& attribute : kVertexAttributes) glEnableVertexAttribArray(attribute.place);
}

void GpuModel::end_chunks() {
  for (const VertexAttribute& attribute : kVertexAttributes) glDisableVertexAttribArray(attribute.place);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthRangef(0.0f, 1.0f);
}

}  // namespace kasumi
