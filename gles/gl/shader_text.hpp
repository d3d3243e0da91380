// The shaders' stages with all that they include, put into the program when it is built (gles/embed_shaders.cmake).
#pragma once

#include <string_view>

namespace kasumi {

std::string_view shader_text(std::string_view name);  // "object.frag"; empty when there is no such file

}  // namespace kasumi
