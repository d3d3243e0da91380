#include "tests/gles/model/draco_encoder.hpp"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

namespace kasumi {

namespace {

int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, const std::vector<float>& values,
                  int components) {
  const auto count = static_cast<std::uint32_t>(values.size()) / static_cast<std::uint32_t>(components);
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<std::int8_t>(components), draco::DT_FLOAT32, false,
                 static_cast<std::int64_t>(sizeof(float)) * components, 0);
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t i = 0; i < count; ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          values.data() + std::size_t{i} * static_cast<std::size_t>(components));
  return id;
}

}  // namespace

std::vector<std::uint8_t> draco_stream(const PlainMesh& plain, int bits) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(plain.vertices()));
  add_attribute(mesh, draco::GeometryAttribute::POSITION, plain.positions, 3);
  if (!plain.normals.empty()) add_attribute(mesh, draco::GeometryAttribute::NORMAL, plain.normals, 3);
  if (!plain.texture.empty()) add_attribute(mesh, draco::GeometryAttribute::TEX_COORD, plain.texture, 2);
  for (std::size_t i = 0; i + 2 < plain.indices.size(); i += 3)
    mesh.AddFace({draco::PointIndex(plain.indices[i]), draco::PointIndex(plain.indices[i + 1]),
                  draco::PointIndex(plain.indices[i + 2])});
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return {buffer.data(), buffer.data() + buffer.size()};
}

std::vector<std::uint8_t> constant_draco_stream(std::uint32_t vertices, int attributes) {
  draco::Mesh mesh;
  mesh.set_num_points(vertices);
  std::vector<float> positions(std::size_t{3} * vertices);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = static_cast<float>(i % 7 + i / 9 % 5);
  add_attribute(mesh, draco::GeometryAttribute::POSITION, positions, 3);
  for (int i = 0; i < attributes; ++i) {
    const int id = add_attribute(mesh, draco::GeometryAttribute::COLOR, {1, 1, 1, 1}, 4);
    mesh.attribute(id)->SetExplicitMapping(vertices);
    for (std::uint32_t v = 0; v < vertices; ++v)
      mesh.attribute(id)->SetPointMapEntry(draco::PointIndex(v), draco::AttributeValueIndex(0));
  }
  for (std::uint32_t v = 0; v + 2 < vertices; v += 3)
    mesh.AddFace({draco::PointIndex(v), draco::PointIndex(v + 1), draco::PointIndex(v + 2)});
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 4);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::COLOR, 8);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return {buffer.data(), buffer.data() + buffer.size()};
}

}  // namespace kasumi
