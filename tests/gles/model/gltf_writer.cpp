#include "tests/gles/model/gltf_writer.hpp"

#include <algorithm>
#include <iterator>

#include <gtest/gtest.h>

#include "base/files.hpp"
#include "tests/places.hpp"

namespace kasumi {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (i + j < bytes.size() ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += i + j > bytes.size() ? '=' : kDigits[group >> (18 - 6 * j) & 63u];
  }
  return text;
}

GltfFile::GltfFile() {
  json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}, {"nodes", {{{"mesh", 0}}}}};
  json["meshes"] =
      nlohmann::json::array({{{"primitives", nlohmann::json::array({{{"attributes", nlohmann::json::object()}}})}}});
  json["accessors"] = nlohmann::json::array();
  json["bufferViews"] = nlohmann::json::array();
}

int GltfFile::add(const void* data, std::size_t bytes, int component_type, const std::string& type, std::size_t count) {
  while (buffer.size() % 4 != 0) buffer.push_back(0);
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes}});
  json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                               {"componentType", component_type},
                               {"type", type},
                               {"count", count}});
  const auto* first = static_cast<const std::uint8_t*>(data);
  std::copy_n(first, bytes, std::back_inserter(buffer));
  return static_cast<int>(json["accessors"].size()) - 1;
}

int GltfFile::add_floats(const std::vector<float>& values, int components) {
  const std::string type = components == 1 ? "SCALAR" : fmt::format("VEC{}", components);
  return add(values.data(), 4 * values.size(), 5126, type, values.size() / static_cast<std::size_t>(components));
}
int GltfFile::add_bytes(const std::vector<std::uint8_t>& values) {
  return add(values.data(), values.size(), 5121, "SCALAR", values.size());
}
int GltfFile::add_shorts(const std::vector<std::uint16_t>& values) {
  return add(values.data(), 2 * values.size(), 5123, "SCALAR", values.size());
}
int GltfFile::add_words(const std::vector<std::uint32_t>& values) {
  return add(values.data(), 4 * values.size(), 5125, "SCALAR", values.size());
}

void GltfFile::add_picture(const std::vector<std::uint8_t>& file) {
  json["images"] = nlohmann::json::array({{{"uri", "data:image/png;base64," + base64(file)}}});
  json["textures"] = nlohmann::json::array({{{"source", 0}}});
}

namespace {

void add_hollow(nlohmann::json& json, std::size_t bytes) {
  if (bytes > 0)
    json["buffers"].push_back(
        {{"byteLength", bytes}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
}

}  // namespace

std::string GltfFile::text() const {
  nlohmann::json whole = json;
  whole["buffers"] = nlohmann::json::array(
      {{{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}});
  add_hollow(whole, hollow_bytes);
  return whole.dump();
}

std::vector<std::uint8_t> GltfFile::binary() const {
  nlohmann::json whole = json;
  whole["buffers"] = nlohmann::json::array({{{"byteLength", buffer.size()}}});
  add_hollow(whole, hollow_bytes);
  std::string text = whole.dump();
  while (text.size() % 4 != 0) text += ' ';
  std::vector<std::uint8_t> data = buffer;
  while (data.size() % 4 != 0) data.push_back(0);
  std::vector<std::uint8_t> file;
  const auto word = [&](std::size_t value) {
    for (int i = 0; i < 4; ++i) file.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto name = [&](const char* four) { std::copy_n(four, 4, std::back_inserter(file)); };
  name("glTF");
  word(2);
  word(28 + text.size() + data.size());
  word(text.size());
  name("JSON");
  file.insert(file.end(), text.begin(), text.end());
  word(data.size());
  name("BIN\0");
  file.insert(file.end(), data.begin(), data.end());
  return file;
}

Result<Model> GltfFile::read(const std::string& name, const ModelLimits& limits) const {
  const auto path = model_folder() / (name + ".gltf");
  return write_text_file(path, text()).and_then([&] { return read_gltf(path, limits); });
}

GltfFile square_file() {
  GltfFile file;
  file.primitive()["attributes"]["POSITION"] = file.add_floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 3);
  file.primitive()["indices"] = file.add_shorts({0, 1, 2, 0, 2, 3});
  return file;
}

Model loaded(const Result<Model>& model) {
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return model ? *model : Model{};
}

std::filesystem::path model_folder() {
  const std::filesystem::path folder = test_output_folder() / "gles-models";
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace kasumi
