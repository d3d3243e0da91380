// Small glTF files written for a test.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

std::string base64(const std::vector<std::uint8_t>& bytes);

// A document under construction: JSON that a test may change at will, and one buffer.
struct GltfFile {
  nlohmann::json json;
  std::vector<std::uint8_t> buffer;
  std::size_t hollow_bytes = 0;  // not 0: a second buffer of so many bytes, which the file does not bring

  GltfFile();  // an asset with one scene of one node of one mesh of one primitive, which has no attributes yet
  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }
  nlohmann::json& node() { return json["nodes"][0]; }

  // Appends to the buffer, with a view and an accessor; returns the accessor's index.
  int add(const void* data, std::size_t bytes, int component_type, const std::string& type, std::size_t count);
  int add_floats(const std::vector<float>& values, int components);
  int add_bytes(const std::vector<std::uint8_t>& values);
  int add_shorts(const std::vector<std::uint16_t>& values);
  int add_words(const std::vector<std::uint32_t>& values);
  void add_picture(const std::vector<std::uint8_t>& file);  // image 0, texture 0

  std::string text() const;                  // with the buffer as a data URI
  std::vector<std::uint8_t> binary() const;  // GLB
  // Writes it below the test output folder and reads it back.
  Result<Model> read(const std::string& name, const ModelLimits& limits = {}) const;
};

// A square of two triangles in the plane z = 0, from (0, 0) to (1, 1), facing +z: positions 0 .. 3.
GltfFile square_file();

// The model, or a failed expectation with the message and an empty model.
Model loaded(const Result<Model>& model);

std::filesystem::path model_folder();  // below the test output folder; created when missing

}  // namespace kasumi
