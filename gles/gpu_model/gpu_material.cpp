#include "gles/gpu_model/gpu_material.hpp"

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

struct MapBinding {
  const char* define;
  const char* sampler;
  MaterialMap map;
  int unit;
};

// The material's pictures that have a unit.
std::vector<MapBinding> pictures_of(const ModelMaterial& m, const SurfaceUnits& units) {
  std::vector<MapBinding> pictures;
  const auto add = [&](const MapBinding& picture) {
    if (picture.map.used() && picture.unit >= 0) pictures.push_back(picture);
  };
  add({"BASE_MAP", "base_map", {m.texture, false}, units.base});
  if (m.unlit) return pictures;
  add({"NORMAL_MAP", "normal_map", m.normal_map, units.normal});
  if (m.reflects()) add({"ROUGHNESS_MAP", "roughness_map", m.roughness_map, units.roughness});
  add({"OCCLUSION_MAP", "occlusion_map", m.occlusion_map, units.occlusion});
  add({"EMISSION_MAP", "emission_map", m.emission_map, units.emission});
  return pictures;
}

}  // namespace

SurfaceUnits units_for_layer() {
  return {.base = kSurfaceUnit,
          .normal = kPlaneUnit,
          .roughness = kPlaneUnit + 1,
          .occlusion = kPlaneUnit + 2,
          .emission = kLayerUnit,
          .sky = kResponseUnit};
}

SurfaceUnits units_beside_camera(int available) {
  const auto more = [&](int unit) { return unit < available ? unit : -1; };
  return {.base = kSurfaceUnit,
          .normal = more(kMoreSurfaceUnit),
          .roughness = more(kMoreSurfaceUnit + 1),
          .occlusion = more(kMoreSurfaceUnit + 2),
          .emission = more(kMoreSurfaceUnit + 3),
          .sky = kLayerUnit};
}

bool holds(const SurfaceUnits& units, const ModelMaterial& material) {
  const SurfaceUnits all{0, 0, 0, 0, 0, 0};
  return pictures_of(material, units).size() == pictures_of(material, all).size();
}

Defines defines_of(const ModelMaterial& material, std::span<const SurfaceTexture> textures, const SurfaceUnits& units) {
  Defines defines;
  for (const MapBinding& picture : pictures_of(material, units)) {
    // The define's value is the varying with the texture coordinates.
    defines.insert(fmt::format("{} {}", picture.define, picture.map.second ? "v_texture_2" : "v_texture"));
    if (picture.map.second) defines.insert("SECOND_PLACE");
    const SurfaceTexture& texture = textures[static_cast<std::size_t>(picture.map.texture)];
    if (!texture.data && !texture.decodes) defines.insert("DECODE_TEXTURE");
  }
  if (material.alpha == ModelMaterial::Alpha::mask) defines.insert("ALPHA_TEST");
  if (material.alpha == ModelMaterial::Alpha::blend) defines.insert("ALPHA_BLEND");
  if (material.unlit) defines.insert("UNLIT");
  if (material.reflects()) defines.insert("REFLECTS");
  if (!material.unlit && material.emission != glm::vec3(0.0f)) defines.insert("EMITS");
  return defines;
}

void bind_material(const Program& program, const ModelMaterial& material, std::span<const SurfaceTexture> textures,
                   const SurfaceUnits& units) {
  program.set("base_colour", glm::dvec4(material.base_colour));
  program.set("alpha_cutoff", static_cast<double>(material.alpha_cutoff));
  program.set("metal_and_roughness", glm::dvec2(material.metallic, material.roughness));
  program.set("head_on_reflectance", glm::dvec3(material.reflectance));
  program.set("edge_reflectance", static_cast<double>(material.edge_reflectance));
  program.set("normal_scale", static_cast<double>(material.normal_scale));
  program.set("occlusion_strength", static_cast<double>(material.occlusion_strength));
  program.set("emission", glm::dvec3(material.emission));
  for (const MapBinding& picture : pictures_of(material, units)) {
    glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(picture.unit));
    glBindTexture(GL_TEXTURE_2D, textures[static_cast<std::size_t>(picture.map.texture)].texture.name());
    program.set(picture.sampler, picture.unit);
  }
}

}  // namespace kasumi
