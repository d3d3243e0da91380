#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include "gles/packed/module.hpp"

namespace kasumi {

namespace {

// What the stream claims, before the library takes memory for it.
struct Claim {
  std::uint32_t triangles = 0, vertices = 0;
};

Result<Claim> claim_of(std::span<const std::uint8_t> stream) {
  const auto damaged = [] { return fail(FaultKind::bad_input, "not a Draco mesh, or damaged where its size stands"); };
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::DracoHeader header{};
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return damaged();
  if (header.encoder_type != draco::TRIANGULAR_MESH)
    return fail(FaultKind::bad_input, "a Draco stream of points: expected a mesh");
  const int version = header.version_major * 10 + header.version_minor;
  if (version != 22)
    return fail(FaultKind::bad_input, "Draco's bitstream {}.{}: expected 2.2", header.version_major,
                header.version_minor);
  buffer.set_bitstream_version(static_cast<std::uint16_t>(header.version_major << 8 | header.version_minor));
  if ((header.flags & METADATA_FLAG_MASK) != 0) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return damaged();
  }
  Claim claim;
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) {
    std::uint8_t traversal = 0;
    if (!buffer.Decode(&traversal) || !draco::DecodeVarint(&claim.vertices, &buffer) ||
        !draco::DecodeVarint(&claim.triangles, &buffer))
      return damaged();
  } else if (!draco::DecodeVarint(&claim.triangles, &buffer) || !draco::DecodeVarint(&claim.vertices, &buffer)) {
    return damaged();
  }
  return claim;
}

Result<> read_attribute(const draco::Mesh& mesh, DracoAttribute& attribute) {
  const draco::PointAttribute* from = mesh.GetAttributeByUniqueId(attribute.id);
  if (from == nullptr) return fail(FaultKind::bad_input, "no attribute {} in the Draco stream", attribute.id);
  const auto components = static_cast<std::size_t>(attribute.components);
  attribute.values.resize(mesh.num_points() * components);
  const bool whole = from->data_type() != draco::DT_FLOAT32 && from->data_type() != draco::DT_FLOAT64;
  // The library divides by itself what the stream calls normalised.
  const float by = whole && !from->normalized() && attribute.full > 0.0f ? 1.0f / attribute.full : 1.0f;
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    float* to = attribute.values.data() + point * components;
    const auto value = from->mapped_index(draco::PointIndex(point));
    if (value.value() >= from->size() || !from->ConvertValue(value, static_cast<std::int8_t>(components), to))
      return fail(FaultKind::bad_input, "attribute {} of the Draco stream is damaged", attribute.id);
    for (std::size_t c = 0; c < components; ++c) to[c] = std::max(to[c] * by, whole && by != 1.0f ? -1.0f : to[c] * by);
  }
  return {};
}

}  // namespace

Result<DracoMesh> read_draco(std::span<const std::uint8_t> stream, std::span<DracoAttribute> attributes,
                             const DracoLimits& limits) {
  const auto claim = claim_of(stream);
  if (!claim) return fail(claim.error());
  if (claim->triangles > limits.triangles || claim->vertices > limits.vertices)
    return fail(FaultKind::bad_input, "a Draco mesh of {} triangles and {} vertices: expected {} and {} at most",
                claim->triangles, claim->vertices, limits.triangles, limits.vertices);
  if (std::max(claim->triangles, claim->vertices) / kMostForAByte > stream.size())
    return fail(FaultKind::bad_input, "{} bytes of Draco claim {} triangles and {} vertices", stream.size(),
                claim->triangles, claim->vertices);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return fail(FaultKind::bad_input, "damaged Draco mesh: {}", decoded.status().error_msg_string());
  const draco::Mesh& mesh = *decoded.value();
  DracoMesh out;
  out.vertices = mesh.num_points();
  if (out.vertices > limits.vertices || mesh.num_faces() > limits.triangles)
    return fail(FaultKind::bad_input, "a Draco mesh of {} vertices: expected {} at most", out.vertices,
                limits.vertices);
  std::size_t components = 0;
  for (const DracoAttribute& attribute : attributes) components += static_cast<std::size_t>(attribute.components);
  if (out.vertices * components > limits.bytes / sizeof(float))
    return fail(FaultKind::bad_input, "a Draco mesh of {} vertices of {} numbers each: expected {} bytes at most",
                out.vertices, components, limits.bytes);
  out.indices.reserve(std::size_t{3} * mesh.num_faces());
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) {
      if (corner.value() >= out.vertices)
        return fail(FaultKind::bad_input, "damaged Draco mesh: corner {} of {} vertices", corner.value(), out.vertices);
      out.indices.push_back(corner.value());
    }
  for (DracoAttribute& attribute : attributes)
    if (auto read = read_attribute(mesh, attribute); !read) return fail(read.error());
  return out;
}

}  // namespace kasumi
