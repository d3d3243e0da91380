// Pictures inside models: PNG and JPEG.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

// Width and height from a PNG's or JPEG's header, without decoding; empty for anything else.
std::optional<glm::ivec2> picture_size(std::span<const std::uint8_t> file);

// Errors (bad_input, without the file's name): neither PNG nor JPEG, larger than `largest` pixels a side, damaged.
Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest);

}  // namespace kasumi
