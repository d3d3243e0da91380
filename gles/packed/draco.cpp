#include <draco/compression/decode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include "gles/packed/module.hpp"

namespace kasumi {

namespace {

// What the stream claims, before the library takes memory for it.
struct Claim {
  std::uint32_t triangles = 0, vertices = 0;
  bool edgebreaker = false;
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
  claim.edgebreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
  if (claim.edgebreaker) {
    std::uint8_t traversal = 0;
    if (!buffer.Decode(&traversal) || !draco::DecodeVarint(&claim.vertices, &buffer) ||
        !draco::DecodeVarint(&claim.triangles, &buffer))
      return damaged();
  } else if (!draco::DecodeVarint(&claim.triangles, &buffer) || !draco::DecodeVarint(&claim.vertices, &buffer)) {
    return damaged();
  }
  return claim;
}

// Takes no memory for more than so many bytes of attributes: constant ones, of which a stream may have any number, take
// a few of its bytes each.
template <class Decoder>
class BoundedDraco final : public Decoder {
 public:
  explicit BoundedDraco(std::size_t most_bytes) : most_bytes_(most_bytes) {}
  bool too_large() const { return too_large_; }

 private:
  bool DecodeAllAttributes() override {
    std::size_t bytes = 0;  // of a vertex
    for (std::int32_t a = 0; a < this->point_cloud()->num_attributes(); ++a) {
      const auto* attribute = this->point_cloud()->attribute(a);
      bytes += static_cast<std::size_t>(attribute->num_components()) *
               static_cast<std::size_t>(std::max(4, draco::DataTypeLength(attribute->data_type())));
    }
    too_large_ = bytes > 0 && this->point_cloud()->num_points() > most_bytes_ / bytes;
    return !too_large_ && Decoder::DecodeAllAttributes();
  }

  std::size_t most_bytes_;
  bool too_large_ = false;
};

template <class Decoder>
Result<> decode_draco(std::span<const std::uint8_t> stream, std::size_t most_bytes, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  BoundedDraco<Decoder> decoder(most_bytes);
  const auto status = decoder.Decode(draco::DecoderOptions(), &buffer, &mesh);
  if (decoder.too_large())
    return fail(FaultKind::bad_input, "a Draco mesh of {} vertices with {} attributes: expected {} bytes at most",
                mesh.num_points(), mesh.num_attributes(), most_bytes);
  if (!status.ok()) return fail(FaultKind::bad_input, "damaged Draco mesh: {}", status.error_msg_string());
  return {};
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
  draco::Mesh mesh;
  const auto decoded = claim->edgebreaker ? decode_draco<draco::MeshEdgebreakerDecoder>(stream, limits.bytes, mesh)
                                          : decode_draco<draco::MeshSequentialDecoder>(stream, limits.bytes, mesh);
  if (!decoded) return fail(decoded.error());
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
