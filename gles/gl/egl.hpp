// Shared by contexts without a window system. For this room's sources only.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "base/result.hpp"
#include "gles/gl/context.hpp"

namespace kasumi {

// The name of EGL's last error.
std::string egl_reason();

// Whether a list of extensions from eglQueryString contains this one.
bool egl_offers(const char* extensions, std::string_view wanted);

// Opens and initialises a display of this platform. `client_extension` is the extension that provides it
// ("EGL_MESA_platform_surfaceless"). Error: unsupported.
Result<EGLDisplay> open_egl_display(EGLenum platform, std::string_view client_extension, void* native);

// A GLES 2 context that reports resets if EGL_EXT_create_context_robustness is available. It is made current with
// `surface` (EGL_NO_SURFACE: none), which it owns. The display stays initialised when the context is destroyed: EGL
// shares displays within a process, and terminating one would destroy its other users' contexts.
// Errors: unsupported, device.
Result<std::unique_ptr<GlContext>> make_egl_context(EGLDisplay display, EGLConfig config, EGLSurface surface);

}  // namespace kasumi
