#include "gles/gpu_model.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <unordered_map>

#include "gles/gl.hpp"

namespace kasumi {

Result<GpuModel> GpuModel::upload(const Model& model, const GlInfo& info, bool force_encoded_textures,
                                  std::vector<std::string>& notes) {
  if (auto sound = check(model); !sound) return tl::unexpected(sound.error());
  GpuModel made;
  made.materials_ = model.materials;
  made.bounds_ = model.bounds();
  for (const ModelTexture& texture : model.textures) {
    auto uploaded = kasumi::upload(texture, info, force_encoded_textures, notes);
    if (!uploaded) return tl::unexpected(uploaded.error());
    made.textures_.push_back(std::move(*uploaded));
  }

  // Parts of one material share chunks: files cut models into hundreds of parts, and each chunk is a call to the
  // driver.
  for (std::size_t material = 0; material < model.materials.size(); ++material)
    if (auto added = made.add_material(model, static_cast<int>(material)); !added) return tl::unexpected(added.error());
  return made;
}

Result<> GpuModel::add_material(const Model& model, int material) {
  constexpr std::size_t kMostVertices = 65536;
  std::vector<ModelVertex> vertices;
  std::vector<std::uint16_t> indices;
  for (const ModelPart& part : model.parts) {
    if (part.material != material) continue;
    std::unordered_map<std::uint32_t, std::uint16_t> places;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      if (vertices.size() + 3 > kMostVertices) {
        if (auto added = add_chunk(material, vertices, std::move(indices)); !added) return added;
        vertices.clear();
        indices.clear();
        places.clear();
      }
      for (std::size_t j = 0; j < 3; ++j) {
        const std::uint32_t index = part.indices[i + j];
        const auto [place, is_new] = places.emplace(index, static_cast<std::uint16_t>(vertices.size()));
        if (is_new) vertices.push_back(part.vertices[index]);
        indices.push_back(place->second);
      }
    }
  }
  if (indices.empty()) return {};
  return add_chunk(material, vertices, std::move(indices));
}

Result<> GpuModel::add_chunk(int material, const std::vector<ModelVertex>& vertices,
                             std::vector<std::uint16_t> indices) {
  Chunk chunk;
  chunk.material = material;
  chunk.vertices = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, chunk.vertices.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(ModelVertex)), vertices.data(),
               GL_STATIC_DRAW);
  chunk.indices = make_buffer();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint16_t)), indices.data(),
               GL_STATIC_DRAW);
  chunk.positions.reserve(vertices.size());
  for (const ModelVertex& vertex : vertices) chunk.positions.push_back(vertex.position);
  chunk.index_list = std::move(indices);
  chunks_.push_back(std::move(chunk));
  return check_gl("uploading the model");
}

bool GpuModel::has_blended() const {
  return std::ranges::any_of(chunks_, [this](const Chunk& chunk) {
    return materials_[static_cast<std::size_t>(chunk.material)].alpha == ModelMaterial::Alpha::blend;
  });
}

PixelBox GpuModel::look_from(const Projection& projection) {
  PixelBox all;
  for (Chunk& chunk : chunks_) {
    chunk.box = box_of(projection, chunk.positions, chunk.index_list);
    all = united(all, chunk.box);
    if (materials_[static_cast<std::size_t>(chunk.material)].alpha == ModelMaterial::Alpha::blend)
      sort_by_depth(chunk, projection);
  }
  std::ranges::stable_sort(chunks_, std::greater<>(), &Chunk::depth_m);
  return all;
}

void GpuModel::sort_by_depth(Chunk& chunk, const Projection& projection) {
  struct Triangle {
    double depth_m;
    std::array<std::uint16_t, 3> corners;
  };
  std::vector<Triangle> triangles;
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < chunk.index_list.size(); i += 3) {
    Triangle triangle{0.0, {chunk.index_list[i], chunk.index_list[i + 1], chunk.index_list[i + 2]}};
    for (const std::uint16_t corner : triangle.corners)
      triangle.depth_m += (projection.model_to_camera * glm::dvec4(chunk.positions[corner], 1.0)).z / 3.0;
    sum += triangle.depth_m;
    triangles.push_back(triangle);
  }
  std::ranges::stable_sort(triangles, std::greater<>(), &Triangle::depth_m);
  chunk.depth_m = sum / static_cast<double>(triangles.size());
  chunk.index_list.clear();
  for (const Triangle& triangle : triangles)
    chunk.index_list.insert(chunk.index_list.end(), triangle.corners.begin(), triangle.corners.end());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
  glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(chunk.index_list.size() * sizeof(std::uint16_t)),
                  chunk.index_list.data());
}

Result<> GpuModel::draw(Which which, Programs& programs, const Defines& variant, const PixelBox& window,
                        const std::function<void(const Program&)>& set_uniforms) const {
  const bool blended = which == Which::blended;
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(blended ? GL_FALSE : GL_TRUE);
  if (blended) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  } else {
    glDisable(GL_BLEND);
  }
  constexpr std::array<std::pair<unsigned, int>, 4> kAttributes{
      {{kPosition, 3}, {kNormal, 3}, {kTexturePlace, 2}, {kColour, 4}}};
  constexpr std::array<std::size_t, 4> kOffsets{offsetof(ModelVertex, position), offsetof(ModelVertex, normal),
                                                offsetof(ModelVertex, texture), offsetof(ModelVertex, colour)};
  for (const auto& [place, size] : kAttributes) glEnableVertexAttribArray(place);

  const Program* in_use = nullptr;
  for (const Chunk& chunk : chunks_) {
    const ModelMaterial& material = materials_[static_cast<std::size_t>(chunk.material)];
    if ((material.alpha == ModelMaterial::Alpha::blend) != blended) continue;
    if (chunk.box.empty() || (!window.empty() && !overlap(chunk.box, window))) continue;

    Defines defines = variant;
    const SurfaceTexture* texture =
        material.texture < 0 ? nullptr : &textures_[static_cast<std::size_t>(material.texture)];
    if (texture != nullptr) defines.insert("TEXTURED");
    if (texture != nullptr && !texture->decodes) defines.insert("DECODE_TEXTURE");
    if (material.alpha == ModelMaterial::Alpha::mask) defines.insert("ALPHA_TEST");
    if (blended) defines.insert("ALPHA_BLEND");
    const auto program = programs.find(ProgramKind::object, defines);
    if (!program) return tl::unexpected(program.error());
    if (*program != in_use) {
      in_use = *program;
      in_use->use();
      set_uniforms(*in_use);
    }
    in_use->set("base_colour", glm::dvec4(material.base_colour));
    in_use->set("alpha_cutoff", static_cast<double>(material.alpha_cutoff));
    if (texture != nullptr) {
      glActiveTexture(GL_TEXTURE0 + kSurfaceUnit);
      glBindTexture(GL_TEXTURE_2D, texture->texture.name());
      in_use->set("base_texture", kSurfaceUnit);
    }
    if (material.double_sided)
      glDisable(GL_CULL_FACE);
    else
      glEnable(GL_CULL_FACE);

    glBindBuffer(GL_ARRAY_BUFFER, chunk.vertices.name());
    for (std::size_t i = 0; i < kAttributes.size(); ++i)
      glVertexAttribPointer(kAttributes[i].first, kAttributes[i].second, GL_FLOAT, GL_FALSE, sizeof(ModelVertex),
                            reinterpret_cast<const void*>(kOffsets[i]));
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(chunk.index_list.size()), GL_UNSIGNED_SHORT, nullptr);
  }
  for (const auto& [place, size] : kAttributes) glDisableVertexAttribArray(place);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  return check_gl("drawing the model");
}

}  // namespace kasumi
