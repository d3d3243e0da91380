#include "gles/model_material.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "gles/model_picture.hpp"

namespace kasumi {
namespace {

std::vector<double> numbers(const tinygltf::Value& object, const std::string& key, std::vector<double> fallback) {
  if (!object.IsObject() || !object.Has(key)) return fallback;
  const tinygltf::Value& value = object.Get(key);
  std::vector<double> read;
  if (value.IsNumber()) read.push_back(value.GetNumberAsDouble());
  if (value.IsArray())
    for (std::size_t i = 0; i < value.ArrayLen(); ++i) {
      const tinygltf::Value& element = value.Get(static_cast<int>(i));
      if (element.IsNumber()) read.push_back(element.GetNumberAsDouble());
    }
  const bool usable =
      read.size() == fallback.size() && std::ranges::all_of(read, [](double v) { return std::isfinite(v); });
  return usable ? read : fallback;
}

int whole_number(const tinygltf::Value& object, const std::string& key, int fallback) {
  return static_cast<int>(std::clamp(numbers(object, key, {double(fallback)}).front(), -1.0, 1e6));
}

TexturePlacement placement_of(const tinygltf::TextureInfo& info) {
  TexturePlacement placement;
  placement.set = info.texCoord;
  const auto transform = info.extensions.find("KHR_texture_transform");
  if (transform == info.extensions.end()) return placement;
  const tinygltf::Value& value = transform->second;
  const auto offset = numbers(value, "offset", {0.0, 0.0});
  const auto scale = numbers(value, "scale", {1.0, 1.0});
  const double turn = numbers(value, "rotation", {0.0}).front();
  placement.set = whole_number(value, "texCoord", placement.set);
  const double c = std::cos(turn), s = std::sin(turn);
  placement.transform =
      glm::dmat3({c * scale[0], -s * scale[0], 0.0}, {s * scale[1], c * scale[1], 0.0}, {offset[0], offset[1], 1.0});
  return placement;
}

glm::vec4 colour_of(const std::vector<double>& factor) {
  glm::vec4 colour{1.0f};
  for (std::size_t i = 0; i < factor.size() && i < 4; ++i)
    if (std::isfinite(factor[i])) colour[static_cast<int>(i)] = static_cast<float>(std::clamp(factor[i], 0.0, 1.0));
  return colour;
}

TextureWrap wrap_of(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::clamp;
  if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureWrap::mirrored_repeat;
  return TextureWrap::repeat;
}

// Decodes each picture once, however many materials use it.
class TextureReader {
 public:
  TextureReader(const tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits,
                std::vector<std::string>& notes)
      : gltf_(gltf), name_(name), limits_(limits), notes_(notes) {}

  // The place in textures(), -1 where there is no picture to show.
  Result<int> read(int texture) {
    if (texture < 0) return -1;
    if (const auto known = places_.find(texture); known != places_.end()) return known->second;
    if (static_cast<std::size_t>(texture) >= gltf_.textures.size())
      return fail(FaultKind::bad_input, "{}: texture {}: there are {}", name_, texture, gltf_.textures.size());
    const auto read = decode(gltf_.textures[static_cast<std::size_t>(texture)]);
    if (read) places_[texture] = *read;
    return read;
  }

  std::vector<ModelTexture> textures() && { return std::move(textures_); }

 private:
  Result<int> decode(const tinygltf::Texture& texture) {
    if (texture.source < 0) {
      notes_.push_back(fmt::format("{}: a texture without PNG or JPEG is shown without it", name_));
      return -1;
    }
    if (static_cast<std::size_t>(texture.source) >= gltf_.images.size())
      return fail(FaultKind::bad_input, "{}: image {}: there are {}", name_, texture.source, gltf_.images.size());
    const tinygltf::Image& image = gltf_.images[static_cast<std::size_t>(texture.source)];
    const std::string what =
        fmt::format("{}: image {}{}", name_, texture.source, image.uri.empty() ? "" : " (" + image.uri + ")");
    if (image.image.empty())
      return fail(FaultKind::bad_input, "{}: missing: expected a PNG or JPEG within the model's folder", what);
    auto pixels = decode_picture(image.image, limits_.texture_size);
    if (!pixels) return fail(FaultKind::bad_input, "{}: {}", what, pixels.error().message);
    pixels_ += pixels->elements().size();
    if (pixels_ > limits_.texture_pixels)
      return fail(FaultKind::bad_input, "{}: textures of more than {} pixels together", name_, limits_.texture_pixels);
    ModelTexture made;
    made.pixels = std::move(*pixels);
    if (texture.sampler >= 0 && static_cast<std::size_t>(texture.sampler) < gltf_.samplers.size()) {
      const tinygltf::Sampler& sampler = gltf_.samplers[static_cast<std::size_t>(texture.sampler)];
      made.wrap_s = wrap_of(sampler.wrapS);
      made.wrap_t = wrap_of(sampler.wrapT);
      made.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    textures_.push_back(std::move(made));
    return static_cast<int>(textures_.size()) - 1;
  }

  const tinygltf::Model& gltf_;
  const std::string& name_;
  const ModelLimits& limits_;
  std::vector<std::string>& notes_;
  std::map<int, int> places_;
  std::vector<ModelTexture> textures_;
  std::size_t pixels_ = 0;
};

ModelMaterial material_of(const tinygltf::Material& from, tinygltf::TextureInfo& texture) {
  ModelMaterial material;
  material.name = from.name;
  material.base_colour = colour_of(from.pbrMetallicRoughness.baseColorFactor);
  texture = from.pbrMetallicRoughness.baseColorTexture;
  if (const auto older = from.extensions.find("KHR_materials_pbrSpecularGlossiness"); older != from.extensions.end()) {
    material.base_colour = colour_of(numbers(older->second, "diffuseFactor", {1.0, 1.0, 1.0, 1.0}));
    texture = {};
    if (older->second.IsObject() && older->second.Has("diffuseTexture")) {
      texture.index = whole_number(older->second.Get("diffuseTexture"), "index", -1);
      texture.texCoord = whole_number(older->second.Get("diffuseTexture"), "texCoord", 0);
    }
  }
  if (from.alphaMode == "MASK") material.alpha = ModelMaterial::Alpha::mask;
  if (from.alphaMode == "BLEND") material.alpha = ModelMaterial::Alpha::blend;
  if (std::isfinite(from.alphaCutoff))
    material.alpha_cutoff = static_cast<float>(std::clamp(from.alphaCutoff, 0.0, 2.0));
  material.double_sided = from.doubleSided;
  return material;
}

}  // namespace

Result<Surfaces> read_surfaces(const tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits,
                               std::vector<std::string>& notes) {
  Surfaces surfaces;
  TextureReader reader(gltf, name, limits, notes);
  for (const tinygltf::Material& from : gltf.materials) {
    tinygltf::TextureInfo info;
    ModelMaterial material = material_of(from, info);
    const auto texture = reader.read(info.index);
    if (!texture) return tl::unexpected(texture.error());
    material.texture = *texture;
    surfaces.materials.push_back(std::move(material));
    surfaces.placements.push_back(placement_of(info));
  }
  surfaces.materials.push_back({.name = "default"});
  surfaces.placements.emplace_back();
  surfaces.textures = std::move(reader).textures();
  return surfaces;
}

}  // namespace kasumi
