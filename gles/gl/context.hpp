// A GLES 2 context and its driver's properties. A context belongs to the thread that opened it and must outlive every
// GL object created under it.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

struct GlInfo {
  std::string renderer;   // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string vendor;     // "Mesa/X.org"
  std::string version;    // "OpenGL ES 3.2 Mesa 22.3.6"
  int es_major = 2;       // of the version the driver provides; only 2 is requested
  bool software = false;  // llvmpipe, softpipe, SwiftShader: no dma-buf import, and only a few frames a second
  int max_texture_size = 0;
  bool highp_fragments = true;  // false: fragment shaders fall back to mediump (about 3 decimal digits)
  std::set<std::string, std::less<>> extensions;

  bool has(std::string_view extension) const { return extensions.contains(extension); }
};

class GlContext {
 public:
  virtual ~GlContext() = default;
  virtual const GlInfo& info() const = 0;
  virtual Result<> make_current() = 0;
  // Checks whether the current context was lost to a GPU reset; always succeeds if the driver does not report resets.
  // Error: device; everything must be recreated under a new context.
  virtual Result<> check_alive() { return {}; }
};

enum class HeadlessSurface { automatic, surfaceless, pbuffer };

// No window, no display server: Mesa's surfaceless platform, else a pbuffer of the default display. The context is made
// current. Errors: unsupported (no EGL driver offers GLES 2 here), with the reason for each way tried.
Result<std::unique_ptr<GlContext>> open_headless_context(HeadlessSurface surface = HeadlessSurface::automatic);

// The current context's properties.
GlInfo query_gl_info();

}  // namespace kasumi
