#include "gles/model/model_json.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "gles/model/gltf_extensions.hpp"
#include "gles/model/gltf_values.hpp"
#include "gles/model/other_models.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kFromGltf1 = "npx gltf-pipeline -i IN -o OUT.glb converts glTF 1";

std::vector<std::string> names_in(const nlohmann::json& document, const char* key) {
  std::vector<std::string> names;
  if (const auto list = document.find(key); list != document.end() && list->is_array())
    for (const auto& name : *list) names.push_back(name.is_string() ? name.get<std::string>() : "(not a name)");
  return names;
}

// Extensions that anything of a document uses, whatever its lists say.
void add_used(const nlohmann::json& of, std::set<std::string>& used) {
  if (of.is_object())
    if (const auto own = of.find("extensions"); own != of.end() && own->is_object())
      for (const auto& [name, value] : own->items()) used.insert(name);
  if (of.is_structured())
    for (const auto& part : of) add_used(part, used);
}

bool is_hollow(const nlohmann::json& buffer) {
  if (!buffer.is_object() || buffer.contains("uri")) return false;
  const auto extensions = buffer.find("extensions");
  return extensions != buffer.end() && extensions->is_object() &&
         (extensions->contains("EXT_meshopt_compression") || extensions->contains("KHR_meshopt_compression"));
}

// Calls `visit` for each primitive that Draco packed whose indices stand nowhere else.
template <class Document, class Visit>
void each_without_indices(Document& document, Visit visit) {
  const auto list = [](auto& of, const char* key) {
    const auto found = of.is_object() ? of.find(key) : of.end();
    return found != of.end() && found->is_array() ? &*found : nullptr;
  };
  auto* meshes = list(document, "meshes");
  auto* accessors = list(document, "accessors");
  if (meshes == nullptr || accessors == nullptr) return;
  for (auto& mesh : *meshes) {
    auto* primitives = list(mesh, "primitives");
    if (primitives == nullptr) continue;
    for (auto& primitive : *primitives) {
      if (!primitive.is_object() || !primitive.contains("indices") || !primitive.contains("extensions")) continue;
      const auto& extensions = primitive["extensions"];
      const auto& indices = primitive["indices"];
      if (!extensions.is_object() || !extensions.contains("KHR_draco_mesh_compression") ||
          !indices.is_number_unsigned() || indices.template get<std::size_t>() >= accessors->size())
        continue;
      const auto& accessor = (*accessors)[indices.template get<std::size_t>()];
      if (accessor.is_object() && !accessor.contains("bufferView")) visit(primitive);
    }
  }
}

// Data in the JSON under a name that tinygltf does not know, as WebP's; what they are is seen in the data. Empty: none.
std::string known_data_uri(const nlohmann::json& of) {
  if (!of.is_object()) return {};
  const auto uri = of.find("uri");
  if (uri == of.end() || !uri->is_string()) return {};
  const auto& text = uri->get_ref<const std::string&>();
  constexpr std::string_view kBase64 = ";base64,";
  const auto data = text.substr(0, 100).find(kBase64);
  if (!text.starts_with("data:") || data == std::string::npos) return {};
  for (const char* known : {"application/octet-stream", "application/gltf-buffer", "image/png", "image/jpeg"})
    if (text.substr(5, data - 5) == known) return {};
  return "data:application/octet-stream" + text.substr(data);
}

template <class Document, class Visit>
void each_data_uri(Document& document, Visit visit) {
  for (const char* key : {"buffers", "images"})
    if (const auto list = document.find(key); list != document.end() && list->is_array())
      for (auto& of : *list)
        if (auto known = known_data_uri(of); !known.empty()) visit(of, std::move(known));
}

std::uint32_t word(std::span<const std::uint8_t> file, std::size_t at) {
  return static_cast<std::uint32_t>(file[at]) | static_cast<std::uint32_t>(file[at + 1]) << 8 |
         static_cast<std::uint32_t>(file[at + 2]) << 16 | static_cast<std::uint32_t>(file[at + 3]) << 24;
}

// The library that parses takes a picture's bytes out of its buffer without looking whether they lie in it.
void check_picture_views(const nlohmann::json& document, std::string_view name, Problems& problems) {
  const auto element = [&](const char* list, const nlohmann::json& of, const char* key) -> const nlohmann::json* {
    const auto all = document.find(list);
    const auto at = of.find(key);
    if (all == document.end() || !all->is_array() || at == of.end() || !at->is_number_unsigned()) return nullptr;
    const auto index = at->get<std::uint64_t>();
    return index < all->size() && (*all)[index].is_object() ? &(*all)[index] : nullptr;
  };
  const auto number = [](const nlohmann::json& of, const char* key) -> std::optional<std::uint64_t> {
    const auto at = of.find(key);
    if (at == of.end()) return 0;
    return at->is_number_unsigned() ? std::optional(at->get<std::uint64_t>()) : std::nullopt;
  };
  const auto lies_within = [&](const nlohmann::json& image) {
    const auto* view = element("bufferViews", image, "bufferView");
    const auto* buffer = view != nullptr ? element("buffers", *view, "buffer") : nullptr;
    if (buffer == nullptr) return false;
    const auto size = is_hollow(*buffer) ? std::optional<std::uint64_t>(1) : number(*buffer, "byteLength");
    const auto offset = number(*view, "byteOffset"), length = number(*view, "byteLength");
    return size && offset && length && *offset <= *size && *length <= *size - *offset;
  };
  const auto images = document.find("images");
  if (images == document.end() || !images->is_array()) return;
  for (std::size_t i = 0; i < images->size(); ++i)
    if ((*images)[i].is_object() && (*images)[i].contains("bufferView") && !lies_within((*images)[i]))
      problems.add("{}: images {}: its buffer view does not lie within a buffer", name, i);
}

}  // namespace

Result<std::string_view> gltf_json(std::span<const std::uint8_t> file, std::string_view name) {
  const auto text = [&](std::size_t first, std::size_t length) {
    return std::string_view(reinterpret_cast<const char*>(file.data()) + first, length);
  };
  if (file.size() < 4 || std::memcmp(file.data(), "glTF", 4) != 0) return text(0, file.size());
  if (file.size() < 20) return fail(FaultKind::bad_input, "{}: {} bytes are too few for a GLB", name, file.size());
  if (const std::uint32_t version = word(file, 4); version != 2)
    return fail(FaultKind::bad_input, "{}: GLB container of version {}: expected 2 ({})", name, version, kFromGltf1);
  if (const std::size_t length = word(file, 8); length > file.size())
    return fail(FaultKind::bad_input, "{}: the GLB says it has {} bytes, the file has {}", name, length, file.size());
  const std::size_t length = word(file, 12);
  if (length > file.size() - 20 || text(16, 4) != "JSON")
    return fail(FaultKind::bad_input, "{}: the GLB does not begin with a whole JSON chunk", name);
  return text(20, length);
}

Result<GltfClaims> check_gltf_json(std::string_view json, std::string_view name, std::size_t most_values) {
  constexpr int kDeepest = 100;
  if (json_values(json) > most_values)
    return fail(FaultKind::bad_input, "{}: JSON of more than {} values", name, most_values);
  if (const int depth = json_depth(json); depth > kDeepest)
    return fail(FaultKind::bad_input, "{}: JSON nested {} deep: expected {} at most", name, depth, kDeepest);
  const auto document = parse_json(json);
  const auto other_than = [&](std::string_view expected) {
    const auto other = other_model(json, name);
    return fmt::format("{}: {}", name, other.empty() ? expected : other);
  };
  if (document.is_discarded() || !document.is_object())
    return fail(FaultKind::bad_input, "{}", other_than("neither a GLB nor the JSON of a glTF"));

  Problems problems;
  const auto asset = document.find("asset");
  std::string version;
  if (asset != document.end() && asset->is_object())
    if (const auto at = asset->find("version"); at != asset->end() && at->is_string()) version = at->get<std::string>();
  if (version != "2" && !version.starts_with("2."))
    problems.add("{}", other_than(fmt::format("glTF version \"{}\": expected 2.x ({})", version, kFromGltf1)));
  GltfClaims claims;
  claims.extensions = names_in(document, "extensionsUsed");
  for (std::string& wanted : names_in(document, "extensionsRequired")) {
    if (const auto note = extension_note(wanted); note.use == ExtensionUse::unknown)
      problems.add("{}: needs the glTF extension {}, which Kasumi does not read: {}", name, wanted, note.text);
    claims.extensions.push_back(std::move(wanted));
  }
  std::ranges::sort(claims.extensions);
  claims.extensions.erase(std::ranges::unique(claims.extensions).begin(), claims.extensions.end());
  std::set<std::string> used;
  add_used(document, used);
  for (const std::string& extension : claims.extensions) {
    if (!used.contains(extension)) continue;  // some exporters list all that they can write
    const auto note = extension_note(extension);
    if (note.use == ExtensionUse::without)
      add_note(claims.notes, fmt::format("{}: {} is left out: {}", name, extension, note.text));
    if (note.use == ExtensionUse::unknown && extension != "EXT_texture_avif")
      add_note(claims.notes, fmt::format("{}: the extension {} is left out: Kasumi does not know it", name, extension));
  }
  if (const auto buffers = document.find("buffers"); buffers != document.end() && buffers->is_array())
    claims.to_mend = std::ranges::any_of(*buffers, is_hollow);
  each_without_indices(document, [&](const nlohmann::json&) { claims.to_mend = true; });
  each_data_uri(document, [&](const nlohmann::json&, const std::string&) { claims.to_mend = true; });
  check_picture_views(document, name, problems);
  if (!problems.empty()) return fail(problems.fault());
  return claims;
}

std::string mended_json(std::string_view json) {
  auto document = parse_json(json);
  if (!document.is_object()) return std::string(json);
  if (document.contains("buffers") && document["buffers"].is_array())
    for (auto& buffer : document["buffers"])
      if (is_hollow(buffer)) buffer = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
  each_data_uri(document, [](nlohmann::json& of, std::string known) { of["uri"] = std::move(known); });
  each_without_indices(document, [](nlohmann::json& primitive) { primitive.erase("indices"); });
  return text_of_json(document);
}

}  // namespace kasumi
