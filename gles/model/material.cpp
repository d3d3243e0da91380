#include "gles/model/material.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <glm/common.hpp>

#include "gles/model/gltf_values.hpp"
#include "gles/model/model_picture.hpp"
#include "gles/model/other_models.hpp"
#include "gles/model/specular_glossiness.hpp"

namespace kasumi {
namespace {

// A material's reference to a picture.
struct TextureReference {
  int texture = -1;
  TexturePlacement placement;
  int made = -1;  // index in Surfaces::textures of what was made in its place; -1: nothing
};

TexturePlacement placement_of(int set, const tinygltf::ExtensionMap& extensions) {
  TexturePlacement placement;
  placement.set = set;
  const auto transform = extensions.find("KHR_texture_transform");
  if (transform == extensions.end()) return placement;
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

template <class Info>
TextureReference laid(const Info& info) {
  return {info.index, placement_of(info.texCoord, info.extensions)};
}

TextureReference laid(const tinygltf::Value& extension, const std::string& key) {
  if (!extension.IsObject() || !extension.Has(key)) return {};
  const tinygltf::Value& info = extension.Get(key);
  tinygltf::ExtensionMap extensions;
  if (info.IsObject() && info.Has("extensions") && info.Get("extensions").IsObject())
    for (const std::string& name : info.Get("extensions").Keys()) extensions[name] = info.Get("extensions").Get(name);
  return {whole_number(info, "index", -1), placement_of(whole_number(info, "texCoord", 0), extensions)};
}

float fraction(double value, float fallback) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : fallback;
}

glm::vec3 three(const std::vector<double>& values) {
  return values.size() == 3 ? glm::vec3(glm::dvec3(values[0], values[1], values[2])) : glm::vec3(0.0f);
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

  // The index in textures(); -1: no usable picture.
  Result<int> read(int texture, bool data) {
    if (texture < 0) return -1;
    if (const auto known = places_.find({texture, data}); known != places_.end()) return known->second;
    if (static_cast<std::size_t>(texture) >= gltf_.textures.size())
      return fail(FaultKind::bad_input, "{}: texture {}: there are {}", name_, texture, gltf_.textures.size());
    auto decoded = decode(gltf_.textures[static_cast<std::size_t>(texture)], data);
    if (!decoded) return fail(decoded.error());
    return places_[{texture, data}] = *decoded ? keep(std::move(**decoded)) : -1;
  }

  // Of an older material's pictures; diffuse may be -1. Empty: the one of gloss cannot be used.
  struct OlderPictures {
    int diffuse = -1, gloss = -1;
    glm::vec4 diffuse_factor{1.0f};
    glm::vec3 specular_factor{1.0f};
    float gloss_factor = 1.0f;
    friend bool operator==(const OlderPictures&, const OlderPictures&) = default;
  };
  struct MadePictures {
    int colour = -1, roughness = -1;
  };
  Result<std::optional<MadePictures>> convert(const OlderPictures& older) {
    for (const auto& [known, made] : converted_)
      if (known == older) return made;
    for (const int texture : {older.diffuse, older.gloss})
      if (texture >= 0 && static_cast<std::size_t>(texture) >= gltf_.textures.size())
        return fail(FaultKind::bad_input, "{}: texture {}: there are {}", name_, texture, gltf_.textures.size());
    auto gloss = decode(gltf_.textures[static_cast<std::size_t>(older.gloss)], false);
    if (!gloss) return fail(gloss.error());
    if (!*gloss) return std::nullopt;
    std::optional<ModelTexture> diffuse;
    if (older.diffuse >= 0) {
      auto decoded = decode(gltf_.textures[static_cast<std::size_t>(older.diffuse)], false);
      if (!decoded) return fail(decoded.error());
      diffuse = std::move(*decoded);
    }
    auto made = metal_rough(diffuse ? diffuse->pixels : Image<glm::u8vec4>(), older.diffuse_factor, (*gloss)->pixels,
                            older.specular_factor, older.gloss_factor);
    pixels_ += made.colour.elements().size() + made.roughness.elements().size();
    if (pixels_ > limits_.texture_pixels)
      return fail(FaultKind::bad_input, "{}: textures of more than {} pixels together", name_, limits_.texture_pixels);
    ModelTexture colour = diffuse ? std::move(*diffuse) : **gloss, roughness = std::move(**gloss);
    colour.pixels = std::move(made.colour);
    roughness.pixels = std::move(made.roughness);
    roughness.data = true;
    const MadePictures pictures{keep(std::move(colour)), keep(std::move(roughness))};
    converted_.emplace_back(older, pictures);
    return pictures;
  }

  std::vector<ModelTexture> textures() && { return std::move(textures_); }

 private:
  void note(std::string text) { add_note(notes_, fmt::format("{}: {}", name_, text)); }

  // The picture that Kasumi reads; -1: none.
  int source_of(const tinygltf::Texture& texture) {
    constexpr std::array<std::string_view, 2> kRare{"EXT_texture_webp", "KHR_texture_basisu"};
    int source = texture.source;
    for (const std::string_view rare : kRare)
      if (const auto* other = extension_of(texture.extensions, std::string(rare)); source < 0 && other != nullptr)
        source = whole_number(*other, "source", -1);
    std::string kinds;
    for (const auto& [kind, value] : texture.extensions)
      if (std::ranges::find(kRare, kind) == kRare.end()) kinds += fmt::format("{}{}", kinds.empty() ? "" : ", ", kind);
    if (source < 0)
      note(fmt::format("a texture {} is left out: Kasumi reads PNG, JPEG, WebP and KTX2",
                       kinds.empty() ? "without a picture" : "only available through " + kinds));
    else if (!kinds.empty())
      note(fmt::format("of textures of {} the other picture, which they bring, is shown", kinds));
    return source;
  }

  int keep(ModelTexture texture) {
    textures_.push_back(std::move(texture));
    return static_cast<int>(textures_.size()) - 1;
  }

  // Empty: no usable picture.
  Result<std::optional<ModelTexture>> decode(const tinygltf::Texture& texture, bool data) {
    const int source = source_of(texture);
    if (source < 0) return std::nullopt;
    if (static_cast<std::size_t>(source) >= gltf_.images.size())
      return fail(FaultKind::bad_input, "{}: image {}: there are {}", name_, source, gltf_.images.size());
    const tinygltf::Image& image = gltf_.images[static_cast<std::size_t>(source)];
    const std::string what =
        fmt::format("{}: image {}{}", name_, source, image.uri.empty() ? "" : " (" + image.uri + ")");
    if (image.image.empty())
      return fail(FaultKind::bad_input, "{}: missing: expected a PNG, JPEG, WebP or KTX2 within the model's folder",
                  what);
    const auto size = model_picture_size(image.image, limits_.texture_size);
    if (!size) {
      const auto other = other_picture(image.image, image.uri);
      return fail(FaultKind::bad_input, "{}: {}", what, other.empty() ? size.error().message : other);
    }
    pixels_ += static_cast<std::size_t>(size->width * size->height);
    if (pixels_ > limits_.texture_pixels)
      return fail(FaultKind::bad_input, "{}: textures of more than {} pixels together", name_, limits_.texture_pixels);
    if (image.image.size() > limits_.all_bytes - bytes_)
      return fail(FaultKind::bad_input, "{}: with it textures of more than {} bytes are decoded", what,
                  limits_.all_bytes);
    bytes_ += image.image.size();
    auto pixels = decode_picture(image.image, limits_.texture_size);
    if (!pixels) return fail(pixels.error().kind, "{}: {}", what, pixels.error().message);
    ModelTexture made;
    made.pixels = std::move(*pixels);
    made.data = data;
    if (texture.sampler >= 0 && static_cast<std::size_t>(texture.sampler) < gltf_.samplers.size()) {
      const tinygltf::Sampler& sampler = gltf_.samplers[static_cast<std::size_t>(texture.sampler)];
      made.wrap_s = wrap_of(sampler.wrapS);
      made.wrap_t = wrap_of(sampler.wrapT);
      made.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    return made;
  }

  const tinygltf::Model& gltf_;
  const std::string& name_;
  const ModelLimits& limits_;
  std::vector<std::string>& notes_;
  std::map<std::pair<int, bool>, int> places_;  // by texture and whether it is data
  std::vector<std::pair<OlderPictures, MadePictures>> converted_;
  std::vector<ModelTexture> textures_;
  std::size_t pixels_ = 0;
  std::size_t bytes_ = 0;  // encoded
};

// One material's pictures, each assigned to one of two sets of texture coordinates.
class MaterialReader {
 public:
  MaterialReader(TextureReader& textures, const std::string& name, std::vector<std::string>& notes)
      : textures_(textures), name_(name), notes_(notes) {}

  Result<ModelMaterial> read(const tinygltf::Material& from) {
    ModelMaterial material;
    material.name = from.name;
    if (from.alphaMode == "MASK") material.alpha = ModelMaterial::Alpha::mask;
    if (from.alphaMode == "BLEND") material.alpha = ModelMaterial::Alpha::blend;
    if (std::isfinite(from.alphaCutoff))
      material.alpha_cutoff = static_cast<float>(std::clamp(from.alphaCutoff, 0.0, 2.0));
    material.double_sided = from.doubleSided;
    material.unlit = extension_of(from.extensions, "KHR_materials_unlit") != nullptr;

    TextureReference base, roughness;
    if (const auto* older = extension_of(from.extensions, "KHR_materials_pbrSpecularGlossiness"); older != nullptr) {
      if (auto read = read_older(*older, material, base, roughness); !read) return fail(read.error());
    } else {
      base = laid(from.pbrMetallicRoughness.baseColorTexture);
      roughness = laid(from.pbrMetallicRoughness.metallicRoughnessTexture);
      material.base_colour = colour_of(from.pbrMetallicRoughness.baseColorFactor);
      material.metallic = fraction(from.pbrMetallicRoughness.metallicFactor, 1.0f);
      material.roughness = fraction(from.pbrMetallicRoughness.roughnessFactor, 1.0f);
      read_dielectric(from, material);
      read_transmission(from, material);
    }
    material.normal_scale =
        std::isfinite(from.normalTexture.scale) ? static_cast<float>(from.normalTexture.scale) : 1.0f;
    material.occlusion_strength = fraction(from.occlusionTexture.strength, 1.0f);
    read_emission(from, material);

    MaterialMap base_map;
    const bool lit = !material.unlit;
    Result<> read = add(base, false, "base colour", base_map);
    if (lit) read = read.and_then([&] { return add(laid(from.normalTexture), true, "normal", material.normal_map); });
    if (material.reflects())
      read = read.and_then([&] { return add(roughness, true, "roughness", material.roughness_map); });
    if (lit)
      read = read.and_then([&] { return add(laid(from.occlusionTexture), true, "occlusion", material.occlusion_map); });
    if (lit && material.emission != glm::vec3(0.0f))
      read = read.and_then([&] { return add(laid(from.emissiveTexture), false, "emission", material.emission_map); });
    if (!read) return fail(read.error());
    material.texture = base_map.texture;
    return material;
  }

  const Surfaces::Placements& placements() const { return placements_; }

 private:
  Result<> read_older(const tinygltf::Value& older, ModelMaterial& material, TextureReference& base,
                      TextureReference& roughness) {
    material.base_colour = colour_of(numbers(older, "diffuseFactor", {1.0, 1.0, 1.0, 1.0}));
    const float gloss_factor = fraction(numbers(older, "glossinessFactor", {1.0}).front(), 1.0f);
    material.roughness = 1.0f - gloss_factor;
    material.reflectance =
        glm::clamp(three(numbers(older, "specularFactor", {1.0, 1.0, 1.0})), glm::vec3(0.0f), glm::vec3(1.0f));
    material.edge_reflectance = 1.0f;
    base = laid(older, "diffuseTexture");
    const TextureReference gloss = laid(older, "specularGlossinessTexture");
    if (gloss.texture < 0) return {};
    std::optional<TextureReader::MadePictures> made;
    if (base.texture < 0 || base.placement == gloss.placement) {
      auto converted =
          textures_.convert({base.texture, gloss.texture, material.base_colour, material.reflectance, gloss_factor});
      if (!converted) return fail(converted.error());
      made = *converted;
    }
    material.reflectance = glm::vec3(0.04f);
    if (!made) {  // its full values everywhere would turn walls into mirrors
      material.roughness = 0.8f;
      add_note(notes_,
               fmt::format("{}: material \"{}\": its specularGlossinessTexture is left out", name_, material.name));
      return {};
    }
    material.base_colour = glm::vec4(1.0f, 1.0f, 1.0f, material.base_colour.a);
    material.metallic = material.roughness = 1.0f;
    base = {base.texture, gloss.placement, made->colour};
    roughness = {gloss.texture, gloss.placement, made->roughness};
    return {};
  }

  static void read_dielectric(const tinygltf::Material& from, ModelMaterial& material) {
    double head_on = 0.04;
    if (const auto* refraction = extension_of(from.extensions, "KHR_materials_ior"); refraction != nullptr) {
      const double n = std::max(numbers(*refraction, "ior", {1.5}).front(), 0.0);
      head_on = n == 0.0 ? 1.0 : std::pow((n - 1.0) / (n + 1.0), 2);  // 0 means full reflection
    }
    material.reflectance = glm::vec3(static_cast<float>(head_on));
    material.edge_reflectance = 1.0f;
    if (const auto* specular = extension_of(from.extensions, "KHR_materials_specular"); specular != nullptr) {
      const float strength = fraction(numbers(*specular, "specularFactor", {1.0}).front(), 1.0f);
      const glm::vec3 tint = glm::max(three(numbers(*specular, "specularColorFactor", {1.0, 1.0, 1.0})), 0.0f);
      material.reflectance = glm::min(material.reflectance * tint, 1.0f) * strength;
      material.edge_reflectance = strength;
    }
  }

  // Glass shows what stands behind it, as blended materials do; a tenth of it stays, for its dirt.
  void read_transmission(const tinygltf::Material& from, ModelMaterial& material) {
    const auto* transmission = extension_of(from.extensions, "KHR_materials_transmission");
    if (transmission == nullptr) return;
    const float share = fraction(numbers(*transmission, "transmissionFactor", {0.0}).front(), 0.0f);
    if (share <= 0.0f) return;
    if (transmission->IsObject() && transmission->Has("transmissionTexture")) {
      add_note(notes_, fmt::format("{}: material \"{}\": its transmissionTexture is left out: it is opaque", name_,
                                   material.name));
      return;
    }
    material.alpha = ModelMaterial::Alpha::blend;
    material.base_colour.a *= 1.0f - 0.9f * share;
    add_note(notes_, fmt::format("{}: material \"{}\": light through it (KHR_materials_transmission) is drawn as "
                                 "{:.0f} % opaque",
                                 name_, material.name, 100.0f * material.base_colour.a));
  }

  static void read_emission(const tinygltf::Material& from, ModelMaterial& material) {
    double strength = 1.0;
    if (const auto* stronger = extension_of(from.extensions, "KHR_materials_emissive_strength"); stronger != nullptr)
      strength = std::clamp(numbers(*stronger, "emissiveStrength", {1.0}).front(), 0.0, 1e6);
    for (std::size_t i = 0; i < std::min<std::size_t>(from.emissiveFactor.size(), 3); ++i)
      material.emission[static_cast<int>(i)] =
          static_cast<float>(strength * double(fraction(from.emissiveFactor[i], 0.0f)));
  }

  Result<> add(const TextureReference& picture, bool data, const char* what, MaterialMap& map) {
    const auto texture = picture.made >= 0 ? Result<int>(picture.made) : textures_.read(picture.texture, data);
    if (!texture) return fail(texture.error());
    if (*texture < 0) return {};
    for (std::size_t i = 0; i < placements_.size(); ++i) {
      if (!placements_[i]) placements_[i] = picture.placement;
      if (*placements_[i] != picture.placement) continue;
      map = {*texture, i == 1};
      return {};
    }
    add_note(notes_,
             fmt::format("{}: a material with more than two kinds of texture coordinates: its {} picture is left out",
                         name_, what));
    return {};
  }

  TextureReader& textures_;
  const std::string& name_;
  std::vector<std::string>& notes_;
  Surfaces::Placements placements_;
};

}  // namespace

Result<Surfaces> read_surfaces(const tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits,
                               std::vector<std::string>& notes) {
  if (gltf.materials.size() > limits.materials)
    return fail(FaultKind::bad_input, "{}: {} materials: expected {} at most", name, gltf.materials.size(),
                limits.materials);
  Surfaces surfaces;
  TextureReader textures(gltf, name, limits, notes);
  std::vector<tinygltf::Material> all = gltf.materials;
  all.emplace_back().name = "default";
  for (const tinygltf::Material& from : all) {
    MaterialReader reader(textures, name, notes);
    auto material = reader.read(from);
    if (!material) return fail(material.error());
    surfaces.materials.push_back(std::move(*material));
    surfaces.placements.push_back(reader.placements());
  }
  surfaces.textures = std::move(textures).textures();
  return surfaces;
}

}  // namespace kasumi
