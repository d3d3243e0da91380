#include "tests/gles/model/packed_files.hpp"

#include <meshoptimizer.h>
#include <webp/encode.h>

namespace kasumi {

namespace {

// The view's bytes are appended packed; the view itself lies in the hollow buffer 1.
void pack_view(GltfFile& file, int accessor, const char* mode, const std::vector<std::uint8_t>& packed,
               std::size_t count, std::size_t stride) {
  auto& view = file.json["bufferViews"]
                        [file.json["accessors"][static_cast<std::size_t>(accessor)]["bufferView"].get<std::size_t>()];
  // What stood there last is taken away again.
  file.buffer.resize(view["byteOffset"].get<std::size_t>());
  view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteOffset", file.buffer.size()},
                                                   {"byteLength", packed.size()},
                                                   {"byteStride", stride},
                                                   {"mode", mode},
                                                   {"count", count}};
  view["buffer"] = 1;
  view["byteOffset"] = 0;
  file.buffer.insert(file.buffer.end(), packed.begin(), packed.end());
}

int add_floats_packed(GltfFile& file, const std::vector<float>& values, int components) {
  const int accessor = file.add_floats(values, components);
  const std::size_t stride = 4 * static_cast<std::size_t>(components), count = 4 * values.size() / stride;
  std::vector<std::uint8_t> packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), values.data(), count, stride));
  pack_view(file, accessor, "ATTRIBUTES", packed, count, stride);
  return accessor;
}

int add_indices_packed(GltfFile& file, const std::vector<std::uint32_t>& indices, std::size_t vertices) {
  const int accessor = file.add_words(indices);
  std::vector<std::uint8_t> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  pack_view(file, accessor, "TRIANGLES", packed, indices.size(), 4);
  return accessor;
}

void require(GltfFile& file, const char* extension) {
  auto& required = file.json["extensionsRequired"];
  for (const auto& there : required)
    if (there == extension) return;
  required.push_back(extension);
}

}  // namespace

void add_primitive(GltfFile& file, const PlainMesh& mesh, Packing packing, int draco_bits) {
  nlohmann::json primitive{{"attributes", nlohmann::json::object()}};
  auto& attributes = primitive["attributes"];
  if (packing == Packing::draco) {
    require(file, "KHR_draco_mesh_compression");
    const auto stream = draco_stream(mesh, draco_bits);
    const int bytes = file.add_bytes(stream);
    const auto view = file.json["accessors"][static_cast<std::size_t>(bytes)]["bufferView"];
    nlohmann::json numbers;
    const auto add = [&](const char* name, const std::vector<float>& values, int components, int id) {
      if (values.empty()) return;
      attributes[name] = file.json["accessors"].size();
      file.json["accessors"].push_back({{"componentType", 5126},
                                        {"type", fmt::format("VEC{}", components)},
                                        {"count", values.size() / static_cast<std::size_t>(components)}});
      numbers[name] = id;
    };
    add("POSITION", mesh.positions, 3, 0);
    add("NORMAL", mesh.normals, 3, 1);
    add("TEXCOORD_0", mesh.texture, 2, 2);
    primitive["indices"] = file.json["accessors"].size();
    file.json["accessors"].push_back({{"componentType", 5125}, {"type", "SCALAR"}, {"count", mesh.indices.size()}});
    primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", numbers}};
  } else if (packing == Packing::meshopt) {
    require(file, "EXT_meshopt_compression");
    attributes["POSITION"] = add_floats_packed(file, mesh.positions, 3);
    if (!mesh.normals.empty()) attributes["NORMAL"] = add_floats_packed(file, mesh.normals, 3);
    if (!mesh.texture.empty()) attributes["TEXCOORD_0"] = add_floats_packed(file, mesh.texture, 2);
    primitive["indices"] = add_indices_packed(file, mesh.indices, mesh.vertices());
    file.hollow_bytes = 1000;
  } else {
    attributes["POSITION"] = file.add_floats(mesh.positions, 3);
    if (!mesh.normals.empty()) attributes["NORMAL"] = file.add_floats(mesh.normals, 3);
    if (!mesh.texture.empty()) attributes["TEXCOORD_0"] = file.add_floats(mesh.texture, 2);
    primitive["indices"] = file.add_words(mesh.indices);
  }
  file.json["meshes"][0]["primitives"].push_back(primitive);
}

std::vector<std::uint8_t> webp_file(const std::vector<std::uint8_t>& rgba, int width, int height) {
  std::uint8_t* made = nullptr;
  const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &made);
  std::vector<std::uint8_t> file(made, made + size);
  WebPFree(made);
  return file;
}

}  // namespace kasumi
