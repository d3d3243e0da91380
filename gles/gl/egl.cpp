#include "gles/gl/egl.hpp"

#include <array>

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

class EglContext final : public GlContext {
 public:
  EglContext(EGLDisplay display, EGLSurface surface, EGLContext context, bool reports_resets)
      : display_(display), surface_(surface), context_(context), reports_resets_(reports_resets) {}
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() override {
    if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
  }

  const GlInfo& info() const override { return info_; }

  Result<> make_current() override {
    eglBindAPI(EGL_OPENGL_ES_API);
    if (!eglMakeCurrent(display_, surface_, surface_, context_))
      return fail(FaultKind::device, "EGL: the context cannot be made current: {}", egl_reason());
    if (info_.renderer.empty()) {
      info_ = query_gl_info();
      if (reports_resets_ && info_.has("GL_EXT_robustness"))
        reset_status_ =
            reinterpret_cast<PFNGLGETGRAPHICSRESETSTATUSEXTPROC>(eglGetProcAddress("glGetGraphicsResetStatusEXT"));
    }
    return {};
  }

  Result<> check_alive() override {
    switch (reset_status_ == nullptr ? GL_NO_ERROR : reset_status_()) {
      case GL_NO_ERROR: return {};
      case GL_GUILTY_CONTEXT_RESET_EXT: return fail(FaultKind::device, "GL context lost: our drawing hung the GPU");
      case GL_INNOCENT_CONTEXT_RESET_EXT:
        return fail(FaultKind::device, "GL context lost: another program hung the GPU");
      default: return fail(FaultKind::device, "GL context lost: the GPU was reset");
    }
  }

 private:
  EGLDisplay display_;
  EGLSurface surface_;
  EGLContext context_;
  bool reports_resets_;
  PFNGLGETGRAPHICSRESETSTATUSEXTPROC reset_status_ = nullptr;
  GlInfo info_;
};

}  // namespace

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
    case EGL_BAD_SURFACE: return "EGL_BAD_SURFACE";
    case EGL_BAD_NATIVE_WINDOW: return "EGL_BAD_NATIVE_WINDOW";
    case EGL_CONTEXT_LOST: return "EGL_CONTEXT_LOST";
    default: return fmt::format("EGL error {:#x}", code);
  }
}

bool egl_offers(const char* extensions, std::string_view wanted) {
  const std::string all = fmt::format(" {} ", extensions == nullptr ? "" : extensions);
  return all.find(fmt::format(" {} ", wanted)) != std::string::npos;
}

Result<EGLDisplay> open_egl_display(EGLenum platform, std::string_view client_extension, void* native) {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!egl_offers(client, client_extension) || !egl_offers(client, "EGL_EXT_platform_base"))
    return fail(FaultKind::unsupported, "{} is missing", client_extension);
  const auto platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (platform_display == nullptr) return fail(FaultKind::unsupported, "eglGetPlatformDisplayEXT is missing");
  const EGLDisplay display = platform_display(platform, native, nullptr);
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor))
    return fail(FaultKind::unsupported, "no display: {}", egl_reason());
  return display;
}

Result<std::unique_ptr<GlContext>> make_egl_context(EGLDisplay display, EGLConfig config, EGLSurface surface) {
  if (!eglBindAPI(EGL_OPENGL_ES_API)) return fail(FaultKind::unsupported, "no OpenGL ES: {}", egl_reason());
  constexpr std::array<EGLint, 5> kRobust{EGL_CONTEXT_CLIENT_VERSION, 2,
                                          EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT,
                                          EGL_LOSE_CONTEXT_ON_RESET_EXT, EGL_NONE};
  constexpr std::array<EGLint, 3> kPlain{EGL_CONTEXT_CLIENT_VERSION, 2, EGL_NONE};
  EGLContext context = EGL_NO_CONTEXT;
  if (egl_offers(eglQueryString(display, EGL_EXTENSIONS), "EGL_EXT_create_context_robustness"))
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, kRobust.data());
  const bool reports_resets = context != EGL_NO_CONTEXT;
  if (!reports_resets) context = eglCreateContext(display, config, EGL_NO_CONTEXT, kPlain.data());
  if (context == EGL_NO_CONTEXT) {
    auto fault = fail(FaultKind::unsupported, "no GLES 2 context: {}", egl_reason());
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    return fault;
  }
  auto made = std::make_unique<EglContext>(display, surface, context, reports_resets);
  if (auto current = made->make_current(); !current) return fail(current.error());
  return made;
}

}  // namespace kasumi
