// Files that people bring as models, and that are no glTF.
#pragma once

#include <string>
#include <string_view>

namespace kasumi {

// What it is, and what makes a glTF of it. `name`: the file's, for its ending. Empty: nothing known.
std::string other_model(std::string_view bytes, std::string_view name);

}  // namespace kasumi
