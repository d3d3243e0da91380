// What stands in the module kasumi-rare-models.so (gles/model/rare_models.hpp): one file for each library, and Basis
// Universal's textures, for which Debian has none.
#pragma once

#include "gles/model/rare_models.hpp"

namespace kasumi {

Result<DracoMesh> read_draco(std::span<const std::uint8_t> stream, std::span<DracoAttribute> attributes,
                             const DracoLimits& limits);
Result<std::vector<std::uint8_t>> read_meshopt(std::span<const std::uint8_t> stream, const MeshoptBuffer& view,
                                               std::size_t most);
Result<Image<glm::u8vec4>> read_webp(std::span<const std::uint8_t> file, int width, int height);
Result<Image<glm::u8vec4>> read_ktx2(std::span<const std::uint8_t> file, int width, int height);
std::vector<std::uint32_t> simplified_mesh(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                           float error);

// The least bytes of a stream for as much as it claims: no compressor known packs a thousand to one.
constexpr std::size_t kMostForAByte = 1000;

}  // namespace kasumi
