// The files of gles/shaders, put into the program when it is built.
#pragma once

#include <string_view>

namespace kasumi {

std::string_view shader_text(std::string_view name);  // "object.frag"; empty when there is no such file

}  // namespace kasumi
