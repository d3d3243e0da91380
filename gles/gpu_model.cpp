#include "gles/gpu_model.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <tuple>

#include "gles/gl.hpp"

namespace kasumi {

std::vector<GpuModel::Triangle> GpuModel::triangles_of(const Model& model, int material) {
  std::vector<Triangle> triangles;
  for (std::size_t p = 0; p < model.parts.size(); ++p) {
    const ModelPart& part = model.parts[p];
    if (part.material != material) continue;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const auto at = [&](std::size_t j) { return part.vertices[part.indices[i + j]].position; };
      triangles.push_back(
          {static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(i), (at(0) + at(1) + at(2)) / 3.0f});
    }
  }
  return triangles;
}

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

  // Parts of one material are drawn together, for files cut models into hundreds of parts and each draw is a call to
  // the driver; then split in space, so that a tile of the picture draws only what is near it.
  for (std::size_t material = 0; material < model.materials.size(); ++material) {
    std::vector<Triangle> triangles = triangles_of(model, static_cast<int>(material));
    if (auto added = made.add_split(model, static_cast<int>(material), triangles); !added)
      return tl::unexpected(added.error());
  }
  return made;
}

Result<> GpuModel::add_split(const Model& model, int material, std::span<Triangle> triangles) {
  constexpr std::size_t kMostTriangles = 2048;
  if (triangles.empty()) return {};
  if (triangles.size() <= kMostTriangles) return add_chunk(model, material, triangles);
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
  return add_split(model, material, {triangles.begin(), middle}).and_then([&] {
    return add_split(model, material, {middle, triangles.end()});
  });
}

Result<> GpuModel::add_chunk(const Model& model, int material, std::span<const Triangle> triangles) {
  Chunk chunk;
  chunk.material = material;
  std::vector<ModelVertex> vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint16_t> places;  // part and index
  for (const Triangle& triangle : triangles) {
    const ModelPart& part = model.parts[triangle.part];
    for (std::uint32_t j = 0; j < 3; ++j) {
      const std::uint32_t index = part.indices[triangle.first_index + j];
      const auto [place, is_new] =
          places.emplace(std::pair(triangle.part, index), static_cast<std::uint16_t>(vertices.size()));
      if (is_new) {
        vertices.push_back(part.vertices[index]);
        chunk.positions.push_back(part.vertices[index].position);
      }
      chunk.index_list.push_back(place->second);
    }
  }
  chunk.vertices = make_buffer();
  glBindBuffer(GL_ARRAY_BUFFER, chunk.vertices.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(ModelVertex)), vertices.data(),
               GL_STATIC_DRAW);
  chunk.indices = make_buffer();
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, chunk.indices.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(chunk.index_list.size() * sizeof(std::uint16_t)),
               chunk.index_list.data(), GL_STATIC_DRAW);
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
  struct Placed {
    double depth_m;
    std::array<std::uint16_t, 3> corners;
  };
  std::vector<Placed> triangles;
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < chunk.index_list.size(); i += 3) {
    Placed triangle{0.0, {chunk.index_list[i], chunk.index_list[i + 1], chunk.index_list[i + 2]}};
    for (const std::uint16_t corner : triangle.corners)
      triangle.depth_m += (projection.model_to_camera * glm::dvec4(chunk.positions[corner], 1.0)).z / 3.0;
    sum += triangle.depth_m;
    triangles.push_back(triangle);
  }
  std::ranges::stable_sort(triangles, std::greater<>(), &Placed::depth_m);
  chunk.depth_m = sum / static_cast<double>(triangles.size());
  chunk.index_list.clear();
  for (const Placed& triangle : triangles)
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
