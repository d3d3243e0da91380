# cmake -DOUT=shader_texts.cpp -DSHADERS="a.vert;b.frag" -P embed_shaders.cmake: the shader files as C++ strings, so that
# the program finds them wherever it runs.
set(text "// Made by embed_shaders.cmake from gles/shaders.\n#include \"gles/shader_text.hpp\"\n\nnamespace kasumi {\n\n")
string(APPEND text "std::string_view shader_text(std::string_view name) {\n")
foreach(shader ${SHADERS})
  file(READ ${shader} body)
  get_filename_component(name ${shader} NAME)
  string(APPEND text "  if (name == \"${name}\") return R\"glsl(${body})glsl\";\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace kasumi\n")
file(WRITE ${OUT} "${text}")
