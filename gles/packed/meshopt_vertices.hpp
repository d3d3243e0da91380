// Vertex streams of version 1, which Debian's meshoptimizer (0.18) does not read: KHR_meshopt_compression, "Mode 0".
// The order of the bytes is that of the format's reference decoder (meshoptimizer, J. St. Pierre and A. Kapoulkine).
#pragma once

#include <cstdint>
#include <span>

namespace kasumi {

// stream begins with 0xa1; stride: a multiple of 4 up to 256; out: count * stride bytes. False: damaged; `out` is then
// filled in part. Reads nothing beyond the stream.
bool decode_vertices_1(std::span<const std::uint8_t> stream, std::size_t count, std::size_t stride,
                       std::span<std::uint8_t> out);

}  // namespace kasumi
