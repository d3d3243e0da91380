// Files that people bring as models, and that are no glTF.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace kasumi {

// What it is, and what makes a glTF of it. `name`: the file's, for its ending. Empty: nothing known.
std::string other_model(std::string_view bytes, std::string_view name);

// The same of a file that a model names, where its place holds only a message of Git's or of a web server's.
std::string other_than_data(std::span<const std::uint8_t> bytes);

// What a texture's picture is that is none of glTF's kinds, and what makes one of it; else empty. `name` may be empty.
std::string other_picture(std::span<const std::uint8_t> bytes, std::string_view name);

}  // namespace kasumi
