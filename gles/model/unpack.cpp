#include "gles/model/unpack.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "gles/model/gltf_values.hpp"
#include "gles/model/rare_models.hpp"

namespace kasumi {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

// A size or an offset of an extension: whole, from 0; `most` + 1 stands for anything beyond.
std::size_t size_in(const tinygltf::Value& object, const std::string& key, std::size_t most) {
  const double value = numbers(object, key, {0.0}).front();
  return value >= 0.0 && value <= double(most) ? static_cast<std::size_t>(value) : most + 1;
}

using PackedBytes = std::span<const std::uint8_t>;

Result<PackedBytes> bytes_of(const tinygltf::Model& gltf, int buffer, std::size_t offset, std::size_t length) {
  if (buffer < 0 || static_cast<std::size_t>(buffer) >= gltf.buffers.size())
    return fail(FaultKind::bad_input, "buffer {}: there are {}", buffer, gltf.buffers.size());
  const auto& bytes = gltf.buffers[static_cast<std::size_t>(buffer)].data;
  if (offset > bytes.size() || length > bytes.size() - offset)
    return fail(FaultKind::bad_input, "bytes {} + {} of buffer {}, which has {}", offset, length, buffer, bytes.size());
  return PackedBytes(bytes).subspan(offset, length);
}

Result<std::vector<std::uint8_t>> unpacked(const tinygltf::Model& gltf, const tinygltf::Value& packed,
                                           std::size_t most) {
  const auto stream = bytes_of(gltf, whole_number(packed, "buffer", -1), size_in(packed, "byteOffset", SIZE_MAX / 4),
                               size_in(packed, "byteLength", SIZE_MAX / 4));
  if (!stream) return fail(stream.error());
  MeshoptBuffer view;
  view.mode = text(packed, "mode");
  view.filter = text(packed, "filter");
  view.count = size_in(packed, "count", SIZE_MAX / 4);
  view.stride = size_in(packed, "byteStride", 256);
  const auto models = rare_models();
  if (!models) return fail(models.error());
  return (*models)->meshopt_view(*stream, view, most);
}

int add_buffer(tinygltf::Model& gltf, std::vector<std::uint8_t> bytes) {
  gltf.buffers.emplace_back().data = std::move(bytes);
  return static_cast<int>(gltf.buffers.size()) - 1;
}

template <class T>
int add_accessor(tinygltf::Model& gltf, const std::vector<T>& values, int type, int component_type,
                 std::size_t components) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  tinygltf::BufferView view;
  view.byteLength = bytes.size();
  view.buffer = add_buffer(gltf, std::move(bytes));
  gltf.bufferViews.push_back(view);
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(gltf.bufferViews.size()) - 1;
  accessor.componentType = component_type;
  accessor.type = type;
  accessor.count = values.size() / components;
  gltf.accessors.push_back(accessor);
  return static_cast<int>(gltf.accessors.size()) - 1;
}

float full_of(const tinygltf::Accessor& accessor) {
  if (!accessor.normalized) return 0.0f;
  switch (accessor.componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return 127.0f;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 255.0f;
    case TINYGLTF_COMPONENT_TYPE_SHORT: return 32767.0f;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 65535.0f;
    default: return 0.0f;
  }
}

const tinygltf::Accessor* accessor_at(const tinygltf::Model& gltf, int index) {
  if (index < 0 || static_cast<std::size_t>(index) >= gltf.accessors.size()) return nullptr;
  return &gltf.accessors[static_cast<std::size_t>(index)];
}

// The same mesh stands in the file unpacked, for readers without Draco.
bool stands_unpacked(const tinygltf::Model& gltf, const tinygltf::Primitive& primitive) {
  const auto holds = [&](int index) {
    const auto* accessor = accessor_at(gltf, index);
    return accessor != nullptr && accessor->bufferView >= 0;
  };
  const auto position = primitive.attributes.find("POSITION");
  return position != primitive.attributes.end() && holds(position->second) &&
         (primitive.indices < 0 || holds(primitive.indices));
}

Result<> decode_primitive(tinygltf::Model& gltf, tinygltf::Primitive& primitive, const ModelLimits& limits,
                          std::size_t& unpacked) {
  const tinygltf::Value& packed = primitive.extensions.at(kDraco);
  const int view_index = whole_number(packed, "bufferView", -1);
  if (view_index < 0 || static_cast<std::size_t>(view_index) >= gltf.bufferViews.size())
    return fail(FaultKind::bad_input, "buffer view {}: there are {}", view_index, gltf.bufferViews.size());
  const tinygltf::BufferView& view = gltf.bufferViews[static_cast<std::size_t>(view_index)];
  const auto stream = bytes_of(gltf, view.buffer, view.byteOffset, view.byteLength);
  if (!stream) return fail(stream.error());
  std::vector<std::string> names;
  std::vector<DracoAttribute> attributes;
  for (const auto& [semantic, index] : primitive.attributes) {
    const auto* accessor = accessor_at(gltf, index);
    if (accessor == nullptr)
      return fail(FaultKind::bad_input, "{} (accessor {}): there are {}", semantic, index, gltf.accessors.size());
    if (!packed.Has("attributes") || !packed.Get("attributes").IsObject() || !packed.Get("attributes").Has(semantic))
      continue;  // stands in the file as it is
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor->type));
    if (components < 1 || components > 4)
      return fail(FaultKind::bad_input, "{}: elements of {} components", semantic, components);
    const int id = whole_number(packed.Get("attributes"), semantic, -1);
    names.push_back(semantic);
    attributes.push_back({static_cast<std::uint32_t>(id), components, full_of(*accessor), {}});
  }
  const auto models = rare_models();
  if (!models) return fail(models.error());
  const auto mesh =
      (*models)->draco_mesh(*stream, attributes, {limits.triangles, limits.vertices, limits.file_bytes - unpacked});
  if (!mesh) return fail(mesh.error());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int components = attributes[i].components;
    primitive.attributes[names[i]] =
        add_accessor(gltf, attributes[i].values, components == 1 ? TINYGLTF_TYPE_SCALAR : components,
                     TINYGLTF_COMPONENT_TYPE_FLOAT, static_cast<std::size_t>(components));
  }
  for (const DracoAttribute& attribute : attributes) unpacked += attribute.values.size() * sizeof(float);
  primitive.indices = add_accessor(gltf, mesh->indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 1);
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.extensions.erase(kDraco);
  return {};
}

}  // namespace

Result<> unpack_views(tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits) {
  std::size_t left = limits.file_bytes;
  for (std::size_t i = 0; i < gltf.bufferViews.size(); ++i) {
    const tinygltf::Value* packed = nullptr;
    for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
      if (packed == nullptr) packed = extension_of(gltf.bufferViews[i].extensions, extension);
    if (packed == nullptr) continue;
    auto bytes = unpacked(gltf, *packed, left);
    if (!bytes) return fail(bytes.error().kind, "{}: buffer view {}: {}", name, i, bytes.error().message);
    left -= bytes->size();
    tinygltf::BufferView& view = gltf.bufferViews[i];
    view.byteOffset = 0;
    view.byteLength = bytes->size();
    view.buffer = add_buffer(gltf, std::move(*bytes));
  }
  return {};
}

Result<> unpack_primitive(tinygltf::Model& gltf, tinygltf::Primitive& primitive, const std::string& what,
                          const ModelLimits& limits, std::size_t& unpacked, std::vector<std::string>& notes) {
  if (!primitive.extensions.contains(kDraco)) return {};
  auto decoded = decode_primitive(gltf, primitive, limits, unpacked);
  if (decoded) return {};
  if (!stands_unpacked(gltf, primitive)) return fail(decoded.error().kind, "{}: {}", what, decoded.error().message);
  add_note(notes, fmt::format("{}: {}: its unpacked copy is taken", what, decoded.error().message));
  primitive.extensions.erase(kDraco);
  return {};
}

}  // namespace kasumi
