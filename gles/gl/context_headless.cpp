#include <array>

#include "gles/gl/egl.hpp"

namespace kasumi {
namespace {

Result<std::unique_ptr<GlContext>> open_on(EGLDisplay display, bool surfaceless) {
  const std::array<EGLint, 11> wanted{EGL_RENDERABLE_TYPE,
                                      EGL_OPENGL_ES2_BIT,
                                      EGL_SURFACE_TYPE,
                                      surfaceless ? EGL_DONT_CARE : EGL_PBUFFER_BIT,
                                      EGL_RED_SIZE,
                                      8,
                                      EGL_GREEN_SIZE,
                                      8,
                                      EGL_BLUE_SIZE,
                                      8,
                                      EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted.data(), &config, 1, &count) || count == 0)
    return fail(FaultKind::unsupported, "no 8-bit GLES 2 configuration: {}", egl_reason());
  EGLSurface surface = EGL_NO_SURFACE;
  if (!surfaceless) {
    // One pixel, because all drawing goes to separate framebuffers.
    const std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface = eglCreatePbufferSurface(display, config, size.data());
    if (surface == EGL_NO_SURFACE) return fail(FaultKind::unsupported, "no pbuffer: {}", egl_reason());
  }
  return make_egl_context(display, config, surface);
}

Result<std::unique_ptr<GlContext>> open_surfaceless() {
  const auto display = open_egl_display(EGL_PLATFORM_SURFACELESS_MESA, "EGL_MESA_platform_surfaceless", nullptr);
  if (!display) return fail(display.error());
  if (!egl_offers(eglQueryString(*display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    return fail(FaultKind::unsupported, "EGL_KHR_surfaceless_context is missing");
  return open_on(*display, true);
}

Result<std::unique_ptr<GlContext>> open_pbuffer() {
  const EGLDisplay display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor))
    return fail(FaultKind::unsupported, "no display: {}", egl_reason());
  return open_on(display, false);
}

}  // namespace

Result<std::unique_ptr<GlContext>> open_headless_context(HeadlessSurface surface) {
  std::string answers;
  if (surface != HeadlessSurface::pbuffer) {
    auto context = open_surfaceless();
    if (context) return context;
    answers += fmt::format("; surfaceless: {}", context.error().message);
  }
  if (surface != HeadlessSurface::surfaceless) {
    auto context = open_pbuffer();
    if (context) return context;
    answers += fmt::format("; pbuffer: {}", context.error().message);
  }
  return fail(FaultKind::unsupported, "no headless GLES 2 context (on Debian: apt install libegl-mesa0){}", answers);
}

}  // namespace kasumi
