#include "gles/model/model_json.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"

namespace kasumi {
namespace {

constexpr std::array<std::string_view, 9> kKnownExtensions{
    "KHR_materials_unlit",     "KHR_texture_transform",
    "KHR_mesh_quantization",   "KHR_materials_ior",
    "KHR_materials_specular",  "KHR_materials_emissive_strength",
    "KHR_materials_clearcoat", "KHR_materials_pbrSpecularGlossiness",
    "KHR_lights_punctual"};

// What the user can do about an unsupported extension.
std::string_view advice(std::string_view extension) {
  struct Advice {
    std::string_view extension, text;
  };
  constexpr std::array<Advice, 6> kAdvice{{
      {"KHR_draco_mesh_compression", "Draco-compressed meshes: export without mesh compression"},
      {"EXT_meshopt_compression", "meshopt-compressed meshes: export without them (gltfpack without -c and -cc)"},
      {"KHR_meshopt_compression", "meshopt-compressed meshes: export without them (gltfpack without -c and -cc)"},
      {"KHR_texture_basisu", "KTX2 pictures of Basis Universal: export pictures as PNG or JPEG (gltfpack without -tc)"},
      {"EXT_texture_webp", "WebP pictures: export pictures as PNG or JPEG"},
      {"EXT_texture_avif", "AVIF pictures: export pictures as PNG or JPEG"},
  }};
  const auto found = std::ranges::find(kAdvice, extension, &Advice::extension);
  return found == kAdvice.end() ? "export without it" : found->text;
}

std::uint32_t word(std::span<const std::uint8_t> file, std::size_t at) {
  return static_cast<std::uint32_t>(file[at]) | static_cast<std::uint32_t>(file[at + 1]) << 8 |
         static_cast<std::uint32_t>(file[at + 2]) << 16 | static_cast<std::uint32_t>(file[at + 3]) << 24;
}

}  // namespace

Result<std::string_view> gltf_json(std::span<const std::uint8_t> file, std::string_view name) {
  const auto text = [&](std::size_t first, std::size_t length) {
    return std::string_view(reinterpret_cast<const char*>(file.data()) + first, length);
  };
  if (file.size() < 4 || std::memcmp(file.data(), "glTF", 4) != 0) return text(0, file.size());
  if (file.size() < 20) return fail(FaultKind::bad_input, "{}: {} bytes are too few for a GLB", name, file.size());
  if (const std::uint32_t version = word(file, 4); version != 2)
    return fail(FaultKind::bad_input, "{}: GLB container of version {}: expected 2", name, version);
  if (const std::size_t length = word(file, 8); length > file.size())
    return fail(FaultKind::bad_input, "{}: the GLB says it has {} bytes, the file has {}", name, length, file.size());
  const std::size_t length = word(file, 12);
  if (length > file.size() - 20 || text(16, 4) != "JSON")
    return fail(FaultKind::bad_input, "{}: the GLB does not begin with a whole JSON chunk", name);
  return text(20, length);
}

Result<> check_gltf_json(std::string_view json, std::string_view name) {
  constexpr int kDeepest = 100;
  if (const int depth = json_depth(json); depth > kDeepest)
    return fail(FaultKind::bad_input, "{}: JSON nested {} deep: expected {} at most", name, depth, kDeepest);
  const auto document = nlohmann::json::parse(json, nullptr, false);
  if (document.is_discarded() || !document.is_object())
    return fail(FaultKind::bad_input, "{}: neither a GLB nor the JSON of a glTF", name);

  Problems problems;
  const auto asset = document.find("asset");
  std::string version;
  if (asset != document.end() && asset->is_object())
    if (const auto at = asset->find("version"); at != asset->end() && at->is_string()) version = at->get<std::string>();
  if (!version.starts_with("2."))
    problems.add("{}: glTF version \"{}\": expected 2.x (glTF 1 files have to be converted)", name, version);
  if (const auto required = document.find("extensionsRequired"); required != document.end() && required->is_array())
    for (const auto& extension : *required) {
      const std::string wanted = extension.is_string() ? extension.get<std::string>() : "(not a name)";
      if (std::ranges::find(kKnownExtensions, wanted) == kKnownExtensions.end())
        problems.add("{}: needs the glTF extension {}, which Kasumi does not read: {}", name, wanted, advice(wanted));
    }
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

}  // namespace kasumi
