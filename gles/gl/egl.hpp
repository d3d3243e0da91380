// What contexts without a window system have in common. For this room's sources only.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "base/result.hpp"
#include "gles/gl/context.hpp"

namespace kasumi {

// Why EGL's last call failed, by the name of its error.
std::string egl_reason();

// Whether a list of extensions, as eglQueryString gives it, has this one.
bool egl_offers(const char* extensions, std::string_view wanted);

// A display by its platform, initialised. `client_extension` is the one that brings the platform
// ("EGL_MESA_platform_surfaceless"). Error: unsupported.
Result<EGLDisplay> open_egl_display(EGLenum platform, std::string_view client_extension, void* native);

// A GLES 2 context that tells of resets where EGL_EXT_create_context_robustness is offered. It is made current with
// `surface` (EGL_NO_SURFACE: none), which it owns. The display stays initialised when the context goes: EGL shares
// displays within a process, and terminating one would take the contexts of its other users along.
// Errors: unsupported, device.
Result<std::unique_ptr<GlContext>> make_egl_context(EGLDisplay display, EGLConfig config, EGLSurface surface);

}  // namespace kasumi
