// Textures as the files that a model brings: JPEG where nothing is seen through, PNG else or where that is smaller.
#pragma once

#include <cstdint>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

// One for each. Errors: io, bad_input (no pixels).
Result<std::vector<std::vector<std::uint8_t>>> texture_files(const std::vector<ModelTexture>& textures);

}  // namespace kasumi
