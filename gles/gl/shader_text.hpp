// The shader stages with their includes resolved, embedded at build time (gles/embed_shaders.cmake).
#pragma once

#include <string_view>

namespace kasumi {

std::string_view shader_text(std::string_view name);  // "object.frag"; empty when there is no such file

}  // namespace kasumi
