// Compressed parts of a glTF, unpacked so that they read like any other. For this room's glTF sources only.
#pragma once

#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Buffer views that meshoptimizer packed (EXT_meshopt_compression, KHR_meshopt_compression) get buffers of their own.
// Errors: bad_input (damaged; all together larger than a file of the model may be), unsupported.
Result<> unpack_views(tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits);

// A primitive that Draco packed (KHR_draco_mesh_compression, required or only used) becomes a list of triangles with
// accessors of its own, whose bytes `unpacked` counts; any other stays as it is. What cannot be decoded, but stands in
// the file unpacked as well, is taken from there; `notes` say so. Errors: bad_input (also where all together grow larger
// than a file of the model may be), unsupported.
Result<> unpack_primitive(tinygltf::Model& gltf, tinygltf::Primitive& primitive, const std::string& what,
                          const ModelLimits& limits, std::size_t& unpacked, std::vector<std::string>& notes);

}  // namespace kasumi
