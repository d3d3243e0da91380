// GL that refuses, in the test programs that link this: it stands between Kasumi and the driver.
#pragma once

#include <string>

namespace kasumi {

struct GlFaults {
  std::string shaders_with;    // shaders whose text contains this do not compile; empty: all do
  int no_memory_at_width = 0;  // there is no memory for textures of this width
};
extern GlFaults gl_faults;  // one thread

}  // namespace kasumi
