// Basis Universal's two kinds of texture, each in a file of its own, and the slices of files that they are read from.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

using Ktx2Bytes = std::span<const std::uint8_t>;

// Empty: not all of it is there.
inline std::optional<Ktx2Bytes> ktx2_part(Ktx2Bytes of, std::uint64_t first, std::uint64_t length) {
  if (first > of.size() || length > of.size() - first) return std::nullopt;
  return of.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(length));
}

// `count` bytes, the lowest first. The caller knows that they are there.
inline std::uint64_t ktx2_number(Ktx2Bytes of, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  while (count-- > 0) value = value << 8 | of[at + count];
  return value;
}

// ETC1S packed by BasisLZ. global: of all `images` pictures of the file; level: the bytes of the level whose one picture
// is the first of them, width x height pixels. Errors (bad_input): damaged; a film.
Result<Image<glm::u8vec4>> read_etc1s(Ktx2Bytes global, std::uint64_t images, Ktx2Bytes level, int width, int height);

// UASTC. blocks: 16 bytes for each 4 x 4 pixels, row by row. Errors (bad_input): damaged.
Result<Image<glm::u8vec4>> read_uastc(Ktx2Bytes blocks, int width, int height);

}  // namespace kasumi
