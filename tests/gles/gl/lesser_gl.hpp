// GL as lesser machines have it. Linked into a test program, this file's GL functions come before the driver's: they
// rewrite the precision of fragment shaders, and know only what a small GPU knows.
#pragma once

#include <string>

namespace kasumi {

// Of fragment shaders. `driver`: as the shaders ask. `high`: 32 bits for everything, samplers included. `medium`: a GPU
// that has nothing but medium precision there (Mali-400).
enum class FragmentPrecision { driver, high, medium };

// What GLES 2 promises at least, with vc4's (Raspberry Pi 0 .. 3) textures of 2048 x 2048 and of 64 fragment uniform
// vectors, and of GL's extensions only those that vc4 surely has.
struct GlLimits {
  int texture_size = 2048;
  int varying_vectors = 8;
  int vertex_uniform_vectors = 128;
  int fragment_uniform_vectors = 64;
};

// The most that any program linked by this process took under limits, in vectors as GLES 2 packs variables.
struct GlUse {
  int varying_vectors = 0;
  int vertex_uniform_vectors = 0;
  int fragment_uniform_vectors = 0;
  std::string most_varyings;  // the variables of that program
  std::string most_vertex_uniforms;
};

void set_fragment_precision(FragmentPrecision precision);
void set_gl_limits(const GlLimits* limits);  // null: the driver's own. Contexts opened before keep what they know.
const GlUse& gl_use();

// For the rest of a test.
class LesserGl {
 public:
  explicit LesserGl(FragmentPrecision precision) { set_fragment_precision(precision); }
  explicit LesserGl(const GlLimits& limits) : limits_(limits) { set_gl_limits(&limits_); }
  ~LesserGl() {
    set_fragment_precision(FragmentPrecision::driver);
    set_gl_limits(nullptr);
  }
  LesserGl(const LesserGl&) = delete;
  LesserGl& operator=(const LesserGl&) = delete;

 private:
  GlLimits limits_;
};

}  // namespace kasumi
