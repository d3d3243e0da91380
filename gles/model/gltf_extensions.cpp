#include "gles/model/gltf_extensions.hpp"

#include <algorithm>
#include <array>

namespace kasumi {

ExtensionNote extension_note(std::string_view extension) {
  using enum ExtensionUse;
  struct Row {
    std::string_view extension;
    ExtensionUse use;
    std::string_view text;
  };
  static constexpr std::array kRows{
      Row{"EXT_mesh_gpu_instancing", read, ""},
      Row{"EXT_meshopt_compression", read, ""},
      Row{"EXT_texture_webp", read, ""},
      Row{"KHR_draco_mesh_compression", read, ""},
      Row{"KHR_materials_emissive_strength", read, ""},
      Row{"KHR_materials_ior", read, ""},
      Row{"KHR_materials_pbrSpecularGlossiness", read, ""},
      Row{"KHR_materials_specular", read, ""},
      Row{"KHR_materials_unlit", read, ""},
      Row{"KHR_mesh_quantization", read, ""},
      Row{"KHR_meshopt_compression", read, ""},
      Row{"KHR_node_visibility", read, ""},
      Row{"KHR_texture_basisu", read, ""},
      Row{"KHR_texture_transform", read, ""},
      Row{"KHR_materials_transmission", read, ""},  // reported by each material

      Row{"KHR_animation_pointer", without, "animations are not played"},
      Row{"KHR_lights_punctual", without, "lamps do not shine"},
      Row{"EXT_lights_ies", without, "lamps do not shine"},
      Row{"EXT_lights_image_based", without, "the light is today's"},
      Row{"KHR_materials_anisotropy", without, "brushed metal reflects evenly"},
      Row{"KHR_materials_clearcoat", without, "lacquer lacks its second reflection"},
      Row{"KHR_materials_diffuse_transmission", without, "light does not come through leaves and cloth"},
      Row{"KHR_materials_dispersion", without, "glass has no rainbow"},
      Row{"KHR_materials_iridescence", without, "no colours of thin films"},
      Row{"KHR_materials_sheen", without, "cloth lacks its sheen"},
      Row{"KHR_materials_variants", without, "materials are shown as they are without a variant"},
      Row{"KHR_materials_volume", without, "thick glass has no colour of its own"},
      Row{"KHR_technique_webgl", without, "its own shaders are not used"},
      Row{"KHR_techniques_webgl", without, "its own shaders are not used"},
      Row{"CESIUM_RTC", without, "its place on the globe is not used"},
      Row{"CESIUM_primitive_outline", without, "edges are not drawn"},
      Row{"MSFT_lod", without, "the finest level is shown"},

      Row{"AGI_articulations", metadata, ""},
      Row{"AGI_stk_metadata", metadata, ""},
      Row{"EXT_feature_metadata", metadata, ""},
      Row{"EXT_instance_features", metadata, ""},
      Row{"EXT_mesh_features", metadata, ""},
      Row{"EXT_mesh_manifold", metadata, ""},
      Row{"EXT_structural_metadata", metadata, ""},
      Row{"FB_geometry_metadata", metadata, ""},
      Row{"FB_ngon_encoding", metadata, ""},  // of all that assimp writes
      Row{"KHR_node_hoverability", metadata, ""},
      Row{"KHR_node_selectability", metadata, ""},
      Row{"KHR_xmp", metadata, ""},
      Row{"KHR_xmp_json_ld", metadata, ""},

      Row{"EXT_texture_avif", unknown,
          "AVIF pictures: npx @gltf-transform/cli png IN.glb OUT.glb --formats \"*\" makes PNG of them"},
      Row{"KHR_gaussian_splatting", unknown,
          "a cloud of splats has no surface that light could fall on: deliver the mesh that was made of the same "
          "photographs"},
  };
  const auto* found = std::ranges::find(kRows, extension, &Row::extension);
  if (found == kRows.end()) return {unknown, "export without it"};
  return {found->use, found->text};
}

}  // namespace kasumi
