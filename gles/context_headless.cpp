#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>

#include "gles/context.hpp"

namespace kasumi {
namespace {

std::string egl_reason() {
  switch (const EGLint code = eglGetError()) {
    case EGL_SUCCESS: return "no reason given";
    case EGL_NOT_INITIALIZED: return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ALLOC: return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE: return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG: return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT: return "EGL_BAD_CONTEXT";
    case EGL_BAD_DISPLAY: return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH: return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER: return "EGL_BAD_PARAMETER";
    default: return fmt::format("EGL error {:#x}", code);
  }
}

bool offers(const char* extensions, std::string_view wanted) {
  const std::string all = fmt::format(" {} ", extensions == nullptr ? "" : extensions);
  return all.find(fmt::format(" {} ", wanted)) != std::string::npos;
}

// The display stays initialised when its context goes: EGL shares displays within a process, and terminating one would
// take the contexts of its other users along.
class HeadlessContext final : public GlContext {
 public:
  HeadlessContext(EGLDisplay display, EGLSurface surface, EGLContext context)
      : display_(display), surface_(surface), context_(context) {}
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;
  ~HeadlessContext() override {
    if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
  }

  const GlInfo& info() const override { return info_; }
  Result<> make_current() override {
    eglBindAPI(EGL_OPENGL_ES_API);
    if (!eglMakeCurrent(display_, surface_, surface_, context_))
      return fail(FaultKind::device, "EGL: the context cannot be made current: {}", egl_reason());
    if (info_.renderer.empty()) info_ = query_gl_info();
    return {};
  }

 private:
  EGLDisplay display_;
  EGLSurface surface_;
  EGLContext context_;
  GlInfo info_;
};

Result<std::unique_ptr<GlContext>> open_on(EGLDisplay display, bool surfaceless) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor))
    return fail(FaultKind::unsupported, "no display: {}", egl_reason());
  if (surfaceless && !offers(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    return fail(FaultKind::unsupported, "EGL_KHR_surfaceless_context is missing");
  if (!eglBindAPI(EGL_OPENGL_ES_API)) return fail(FaultKind::unsupported, "no OpenGL ES: {}", egl_reason());

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
  const std::array<EGLint, 3> version{EGL_CONTEXT_CLIENT_VERSION, 2, EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  if (context == EGL_NO_CONTEXT) return fail(FaultKind::unsupported, "no GLES 2 context: {}", egl_reason());

  EGLSurface surface = EGL_NO_SURFACE;
  if (!surfaceless) {
    // One pixel: every picture goes to a framebuffer of our own.
    const std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface = eglCreatePbufferSurface(display, config, size.data());
    if (surface == EGL_NO_SURFACE) {
      auto fault = fail(FaultKind::unsupported, "no pbuffer: {}", egl_reason());
      eglDestroyContext(display, context);
      return fault;
    }
  }
  auto made = std::make_unique<HeadlessContext>(display, surface, context);
  if (auto current = made->make_current(); !current) return tl::unexpected(current.error());
  return made;
}

Result<std::unique_ptr<GlContext>> open_surfaceless() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!offers(client, "EGL_MESA_platform_surfaceless") || !offers(client, "EGL_EXT_platform_base"))
    return fail(FaultKind::unsupported, "EGL_MESA_platform_surfaceless is missing");
  const auto platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (platform_display == nullptr) return fail(FaultKind::unsupported, "eglGetPlatformDisplayEXT is missing");
  return open_on(platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr), true);
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
    auto context = open_on(eglGetDisplay(EGL_DEFAULT_DISPLAY), false);
    if (context) return context;
    answers += fmt::format("; pbuffer: {}", context.error().message);
  }
  return fail(FaultKind::unsupported, "no headless GLES 2 context (on Debian: apt install libegl-mesa0){}", answers);
}

}  // namespace kasumi
