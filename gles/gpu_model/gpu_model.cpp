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

constexpr std::size_t kSliceVertices = 100'000;  // some four megabytes
constexpr std::size_t kMostWaiting = 100'000;    // corners; a triangle waits in some 400 bytes

}  // namespace

GpuModel::Chunk GpuModel::make_chunk(int material, std::span<const GpuVertex> vertices,
                                     std::vector<std::uint16_t> index_list) {
  Chunk chunk;
  chunk.material = material;
  chunk.positions.reserve(vertices.size());
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
  auto upload = ModelUpload::begin(model, nullptr, info, force_encoded_textures, notes);
  if (!upload) return fail(upload.error());
  for (;;) {
    const auto whole = upload->step();
    if (!whole) return fail(whole.error());
    if (*whole) return upload->take();
  }
}

Result<ModelUpload> ModelUpload::begin(const Model& model, std::shared_ptr<const TriangleChunks> chunks,
                                       const GlInfo& info, bool force_encoded_textures,
                                       std::vector<std::string>& notes) {
  if (auto sound = check(model); !sound) return fail(sound.error());
  ModelUpload upload(model, info, notes);
  upload.force_encoded_textures_ = force_encoded_textures;
  upload.chunks_ = chunks ? std::move(chunks) : std::make_shared<const TriangleChunks>(cut_model(model));
  upload.made_.software_ = info.software;
  upload.made_.materials_ = model.materials;
  upload.made_.bounds_ = model.bounds();
  upload.made_.bounds_with_ground_ = model.bounds_with_ground();
  return upload;
}

Result<bool> ModelUpload::texture_step() {
  const std::size_t number = made_.textures_.size();
  if (!texture_)
    texture_ =
        std::make_unique<SurfaceTextureUpload>(model_->textures[number], cutoff_of(*model_, static_cast<int>(number)),
                                               *info_, force_encoded_textures_, *notes_);
  const auto whole = texture_->step();
  if (!whole || !*whole) return whole;
  made_.textures_.push_back(texture_->take());
  made_.bytes_ += made_.textures_.back().bytes;
  texture_.reset();
  return true;
}

Result<bool> ModelUpload::step() {
  if (made_.textures_.size() < model_->textures.size()) {
    if (const auto whole = texture_step(); !whole) return whole;
    return false;
  }
  const auto upload = [this](const std::vector<TriangleChunk>& from, std::size_t& next,
                             std::vector<GpuModel::Chunk>& to) {
    for (std::size_t vertices = 0; next < from.size() && vertices < kSliceVertices; ++next) {
      vertices += from[next].vertices.size();
      made_.add(from[next], to);
    }
    return next == from.size();
  };
  if (!upload(chunks_->solid, solid_, made_.solid_) || !upload(chunks_->ground, ground_, made_.ground_)) return false;
  chunks_.reset();
  made_.add_see_through(*model_);
  if (auto uploaded = check_gl("uploading the model"); !uploaded) return fail(uploaded.error());
  return true;
}

void GpuModel::add(const TriangleChunk& chunk, std::vector<Chunk>& chunks) {
  bytes_ += chunk.vertices.size() * sizeof(GpuVertex) + chunk.indices.size() * sizeof(std::uint16_t);
  chunks.push_back(make_chunk(chunk.material, chunk.vertices, chunk.indices));
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
  ChunkCutter cutter(see_through_.vertices.size());
  std::vector<GpuVertex> corners;
  for (std::size_t i = 0; i < triangles.size();) {
    const std::size_t first = i;
    for (; i < triangles.size() && i - first < kMaxChunkTriangles && triangles[i].material == triangles[first].material;
         ++i)
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
  // Software GL keeps the memory of as many triangles as ever waited for it.
  if (!software_ || (waiting_ += chunk.index_list.size()) < kMostWaiting) return;
  glFinish();
  waiting_ = 0;
}

const std::vector<GpuModel::Chunk>& GpuModel::chunks_of(Which which) const {
  switch (which) {
    case Which::solid: return solid_;
    case Which::blended: return see_through_.chunks;
    case Which::ground: return ground_;
  }
  return solid_;
}

PixelBox GpuModel::box_within(Which which, const PixelBox& window, int margin_px) const {
  PixelBox all;
  for (const Chunk& chunk : chunks_of(which)) all = united(all, common(grown(chunk.box, margin_px), window));
  return all;
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
