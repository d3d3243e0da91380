// Files that people take for pictures, and that no reader here reads.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace kasumi {

// What it is and what is expected instead; empty: nothing known, or a picture that can be read. A camera's raw file is
// one of these, though it is a TIFF: what a reader of TIFFs finds first in it is a thumbnail.
std::string other_kind(std::span<const std::uint8_t> file);

}  // namespace kasumi
