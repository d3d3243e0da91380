#include "tests/pipeline/kiosk/appliance/faulty_gl.hpp"

#include <set>
#include <string_view>
#include <utility>

#include <dlfcn.h>

namespace kasumi {

GlFaults gl_faults;

namespace {

constexpr unsigned kCompileStatus = 0x8B81, kOutOfMemory = 0x0505;
bool out_of_memory = false;
std::set<unsigned> refused_shaders;

template <class Function>
Function* of_the_driver(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace
}  // namespace kasumi

// In the program itself, these are found before the driver's.
extern "C" {
void glShaderSource(unsigned shader, int count, const char* const* texts, const int* lengths);
void glGetShaderiv(unsigned shader, unsigned what, int* value);
void glTexImage2D(unsigned target, int level, int format, int width, int height, int border, unsigned layout,
                  unsigned type, const void* pixels);
unsigned glGetError();

void glShaderSource(unsigned shader, int count, const char* const* texts, const int* lengths) {
  static auto* const real = kasumi::of_the_driver<decltype(glShaderSource)>("glShaderSource");
  real(shader, count, texts, lengths);
  const auto& refused = kasumi::gl_faults.shaders_with;
  kasumi::refused_shaders.erase(shader);
  for (int i = 0; i < count; ++i)
    if (!refused.empty() && std::string_view(texts[i]).find(refused) != std::string_view::npos)
      kasumi::refused_shaders.insert(shader);
}

void glGetShaderiv(unsigned shader, unsigned what, int* value) {
  static auto* const real = kasumi::of_the_driver<decltype(glGetShaderiv)>("glGetShaderiv");
  real(shader, what, value);
  if (kasumi::refused_shaders.contains(shader) && what == kasumi::kCompileStatus) *value = 0;
}

void glTexImage2D(unsigned target, int level, int format, int width, int height, int border, unsigned layout,
                  unsigned type, const void* pixels) {
  static auto* const real = kasumi::of_the_driver<decltype(glTexImage2D)>("glTexImage2D");
  if (width == kasumi::gl_faults.no_memory_at_width) {
    kasumi::out_of_memory = true;
    return;
  }
  real(target, level, format, width, height, border, layout, type, pixels);
}

unsigned glGetError() {
  static auto* const real = kasumi::of_the_driver<decltype(glGetError)>("glGetError");
  if (std::exchange(kasumi::out_of_memory, false)) return kasumi::kOutOfMemory;
  return real();
}
}
