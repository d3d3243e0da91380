// Pictures inside models: PNG, JPEG and, by the module of rare_models.hpp, WebP and KTX2.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/picture_header.hpp"
#include "base/result.hpp"

namespace kasumi {

// Width and height, without decoding. Errors (bad_input, without the file's name): none of these, larger than
// `largest` pixels a side or than any picture (kPhotographLimits).
Result<PictureHeader> model_picture_size(std::span<const std::uint8_t> file, int largest);

// Errors: the same; damaged; unsupported (no module).
Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest);

}  // namespace kasumi
