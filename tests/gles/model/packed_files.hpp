// Models as other programs compress them, made for a test.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/gles/model/draco_encoder.hpp"
#include "tests/gles/model/gltf_writer.hpp"

namespace kasumi {

// Appends a primitive of it to the first mesh: as it is, by Draco, or by meshopt, whose fallback buffer has no bytes.
enum class Packing { none, draco, meshopt };
void add_primitive(GltfFile& file, const PlainMesh& mesh, Packing packing, int draco_bits = 14);

std::vector<std::uint8_t> webp_file(const std::vector<std::uint8_t>& rgba, int width, int height);  // lossless

}  // namespace kasumi
