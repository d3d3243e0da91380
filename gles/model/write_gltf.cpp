#include "gles/model/write_gltf.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"

namespace kasumi {
namespace {

using nlohmann::json;

constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;  // glTF 2.0, 3.6.2.2
constexpr int kVertices = 34962, kIndices = 34963;

int wrap_code(TextureWrap wrap) {
  return wrap == TextureWrap::repeat ? 10497 : wrap == TextureWrap::mirrored_repeat ? 33648 : 33071;
}

json listed(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (i + j < bytes.size() ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += i + j > bytes.size() ? '=' : kDigits[group >> (18 - 6 * j) & 63u];
  }
  return text;
}

class GltfWriter {
 public:
  explicit GltfWriter(std::span<const std::vector<std::uint8_t>> pictures) : pictures_(pictures) {
    file_["asset"] = {{"version", "2.0"}, {"generator", "Kasumi"}};
  }

  void add(const WrittenScene& scene) {
    json written = json::object();
    if (!scene.name.empty()) written["name"] = scene.name;
    if (scene.model) {
      add_node("object", scene.model->parts, *scene.model, written);
      add_node("kasumi_ground", scene.model->ground, *scene.model, written);
      for (const ModelNode& node : scene.model->nodes) add_place(node, written);
    }
    file_["scenes"].push_back(std::move(written));
  }

  std::vector<std::uint8_t> bytes(std::size_t shown, bool text) {
    file_["scene"] = shown;
    for (const auto& extension : extensions_) file_["extensionsUsed"].push_back(extension);
    file_["buffers"] = {{{"byteLength", buffer_.size()}}};
    if (text) file_["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(buffer_);
    std::string words = text_of_json(file_);
    if (text) return {words.begin(), words.end()};
    words.resize((words.size() + 3) / 4 * 4, ' ');
    std::vector<std::uint8_t> made;
    const auto put = [&](std::initializer_list<std::size_t> values) {
      for (const std::size_t value : values)
        for (unsigned shift = 0; shift < 32; shift += 8) made.push_back(static_cast<std::uint8_t>(value >> shift));
    };
    put({0x46546C67, 2, 28 + words.size() + buffer_.size(), words.size(), 0x4E4F534A});
    made.insert(made.end(), words.begin(), words.end());
    put({buffer_.size(), 0x004E4942});
    made.insert(made.end(), buffer_.begin(), buffer_.end());
    return made;
  }

 private:
  void add_node(const char* name, const std::vector<ModelPart>& parts, const Model& model, json& scene) {
    json primitives = json::array();
    for (const ModelPart& part : parts) primitives.push_back(primitive(part, model));
    if (primitives.empty()) return;
    file_["nodes"].push_back({{"name", name}, {"mesh", meshes_++}});
    file_["meshes"].push_back({{"name", name}, {"primitives", std::move(primitives)}});
    scene["nodes"].push_back(nodes_++);
  }

  // Only where it is: its meshes are among the model's parts.
  void add_place(const ModelNode& node, json& scene) {
    const auto &low = node.bounds.lowest, &high = node.bounds.highest;
    file_["nodes"].push_back({{"name", node.name},
                              {"translation", listed(0.5f * (low + high))},
                              {"extras", {{"kasumi_box", {low.x, low.y, low.z, high.x, high.y, high.z}}}}});
    scene["nodes"].push_back(nodes_++);
  }

  std::size_t view(const void* data, std::size_t size, int target) {
    json written = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", size}};
    if (target != 0) written["target"] = target;
    file_["bufferViews"].push_back(std::move(written));
    const std::size_t at = buffer_.size();
    buffer_.resize((at + size + 3) / 4 * 4);
    std::memcpy(buffer_.data() + at, data, size);
    return views_++;
  }

  template <class Element>
  std::size_t accessor(const std::vector<Element>& elements, const char* type, int component, int target = kVertices) {
    file_["accessors"].push_back({{"bufferView", view(elements.data(), elements.size() * sizeof(Element), target)},
                                  {"componentType", component},
                                  {"count", elements.size()},
                                  {"type", type}});
    return accessors_++;
  }

  template <class Value>
  std::size_t floats(const ModelPart& part, const char* type, Value value) {
    std::vector<decltype(value(part.vertices.front()))> values;
    values.reserve(part.vertices.size());
    for (const ModelVertex& vertex : part.vertices) values.push_back(value(vertex));
    return accessor(values, type, kFloat);
  }

  std::size_t positions(const ModelPart& part) {
    glm::vec3 lowest(std::numeric_limits<float>::infinity()), highest(-lowest);
    for (const ModelVertex& vertex : part.vertices) {
      lowest = glm::min(lowest, vertex.position);
      highest = glm::max(highest, vertex.position);
    }
    const std::size_t made = floats(part, "VEC3", [](const ModelVertex& v) { return v.position; });
    file_["accessors"][made]["min"] = listed(lowest);
    file_["accessors"][made]["max"] = listed(highest);
    return made;
  }

  std::size_t colours(const ModelPart& part) {
    std::vector<glm::u16vec4> values;
    for (const ModelVertex& vertex : part.vertices)
      values.emplace_back(glm::round(glm::clamp(vertex.colour, 0.0f, 1.0f) * 65535.0f));
    const std::size_t made = accessor(values, "VEC4", kUnsignedShort);
    file_["accessors"][made]["normalized"] = true;
    return made;
  }

  json primitive(const ModelPart& part, const Model& model) {
    const ModelMaterial& of = model.materials[static_cast<std::size_t>(part.material)];
    json attributes = {{"POSITION", positions(part)},
                       {"NORMAL", floats(part, "VEC3", [](const ModelVertex& v) { return v.normal; })}};
    bool first = of.texture >= 0, second = false;
    for (const MaterialMap& map : {of.roughness_map, of.normal_map, of.occlusion_map, of.emission_map})
      if (map.used()) (map.second ? second : first) = true;
    if (first || second)
      attributes["TEXCOORD_0"] = floats(part, "VEC2", [](const ModelVertex& v) { return v.texture; });
    if (second) attributes["TEXCOORD_1"] = floats(part, "VEC2", [](const ModelVertex& v) { return v.texture_2; });
    if (of.normal_map.used())
      attributes["TANGENT"] = floats(part, "VEC4", [](const ModelVertex& v) { return v.tangent; });
    if (std::ranges::any_of(part.vertices, [](const ModelVertex& v) { return v.colour != glm::vec4(1.0f); }))
      attributes["COLOR_0"] = colours(part);
    const std::vector<std::uint16_t> short_indices(part.indices.begin(), part.indices.end());
    const std::size_t indices = part.vertices.size() <= 65535
                                    ? accessor(short_indices, "SCALAR", kUnsignedShort, kIndices)
                                    : accessor(part.indices, "SCALAR", kUnsignedInt, kIndices);
    return {{"attributes", std::move(attributes)}, {"indices", indices}, {"material", material(part.material, model)}};
  }

  // Where it stands in the file.
  std::size_t texture(int index, const Model& model) {
    const auto [known, fresh] = textures_.try_emplace(index, textures_.size());
    if (!fresh) return known->second;
    const ModelTexture& from = model.textures[static_cast<std::size_t>(index)];
    const auto& picture = pictures_[static_cast<std::size_t>(index)];
    const bool jpeg = picture.size() > 2 && picture[0] == 0xff;
    file_["images"].push_back(
        {{"bufferView", view(picture.data(), picture.size(), 0)}, {"mimeType", jpeg ? "image/jpeg" : "image/png"}});
    file_["samplers"].push_back({{"magFilter", from.nearest ? 9728 : 9729},
                                 {"minFilter", 9987},
                                 {"wrapS", wrap_code(from.wrap_s)},
                                 {"wrapT", wrap_code(from.wrap_t)}});
    file_["textures"].push_back({{"source", known->second}, {"sampler", known->second}});
    return known->second;
  }

  json map(const MaterialMap& map, const Model& model) {
    json made = {{"index", texture(map.texture, model)}};
    if (map.second) made["texCoord"] = 1;
    return made;
  }

  void add_extension(json& material, const char* name, json values) {
    if (std::ranges::find(extensions_, name) == extensions_.end()) extensions_.emplace_back(name);
    material["extensions"][name] = std::move(values);
  }

  std::size_t material(int index, const Model& model) {
    const auto [known, fresh] = materials_.try_emplace(index, materials_.size());
    if (!fresh) return known->second;
    const std::size_t at = known->second;
    const ModelMaterial& from = model.materials[static_cast<std::size_t>(index)];
    json surface = {{"metallicFactor", from.metallic}, {"roughnessFactor", from.roughness}};
    surface["baseColorFactor"] = {from.base_colour.r, from.base_colour.g, from.base_colour.b, from.base_colour.a};
    if (from.texture >= 0) surface["baseColorTexture"] = map({from.texture, false}, model);
    if (from.roughness_map.used()) surface["metallicRoughnessTexture"] = map(from.roughness_map, model);
    json made = {{"name", from.name}, {"doubleSided", from.double_sided}};
    made["pbrMetallicRoughness"] = std::move(surface);
    if (from.alpha == ModelMaterial::Alpha::blend) made["alphaMode"] = "BLEND";
    if (from.alpha == ModelMaterial::Alpha::mask) {
      made["alphaMode"] = "MASK";
      made["alphaCutoff"] = from.alpha_cutoff;
    }
    if (from.normal_map.used()) {
      made["normalTexture"] = map(from.normal_map, model);
      made["normalTexture"]["scale"] = from.normal_scale;
    }
    if (from.occlusion_map.used()) {
      made["occlusionTexture"] = map(from.occlusion_map, model);
      made["occlusionTexture"]["strength"] = from.occlusion_strength;
    }
    add_light(from, model, made);
    file_["materials"].push_back(std::move(made));
    return at;
  }

  // What it shines with, and what it reflects like glass.
  void add_light(const ModelMaterial& from, const Model& model, json& made) {
    if (const float most = std::max({from.emission.r, from.emission.g, from.emission.b, 1.0f});
        from.emission != glm::vec3(0.0f)) {
      made["emissiveFactor"] = listed(from.emission / most);
      if (most > 1.0f) add_extension(made, "KHR_materials_emissive_strength", {{"emissiveStrength", most}});
      if (from.emission_map.used()) made["emissiveTexture"] = map(from.emission_map, model);
    }
    if (from.unlit) return add_extension(made, "KHR_materials_unlit", json::object());
    constexpr float kUsual = 0.04f;
    if (from.edge_reflectance == 1.0f && from.reflectance == glm::vec3(kUsual)) return;
    json specular = {{"specularFactor", from.edge_reflectance}};
    if (from.edge_reflectance > 0.0f)
      specular["specularColorFactor"] = listed(from.reflectance / (kUsual * from.edge_reflectance));
    add_extension(made, "KHR_materials_specular", std::move(specular));
  }

  std::span<const std::vector<std::uint8_t>> pictures_;
  json file_;
  std::vector<std::uint8_t> buffer_;
  std::vector<std::string> extensions_;
  std::map<int, std::size_t> materials_, textures_;  // from where they stood to where they stand
  std::size_t nodes_ = 0, meshes_ = 0, views_ = 0, accessors_ = 0;
};

}  // namespace

std::vector<std::uint8_t> gltf_of(std::span<const WrittenScene> scenes, std::size_t shown,
                                  std::span<const std::vector<std::uint8_t>> pictures, bool text) {
  GltfWriter writer(pictures);
  for (const WrittenScene& scene : scenes) writer.add(scene);
  return writer.bytes(shown, text);
}

}  // namespace kasumi
