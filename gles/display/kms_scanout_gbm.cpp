// GBM and EGL behind kms_scanout.hpp.
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <gbm.h>

#include "base/c_ptr.hpp"
#include "gles/display/kms_scanout.hpp"
#include "gles/gl/egl.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {
namespace {

constexpr std::uint64_t kNoModifier = 0x00ffffffffffffffu;  // DRM_FORMAT_MOD_INVALID

using GbmDevice = CPtr<gbm_device, gbm_device_destroy>;
using GbmSurface = CPtr<gbm_surface, gbm_surface_destroy>;
using GbmBuffer = CPtr<gbm_bo, gbm_bo_destroy>;

// EGL identifies displays by the GBM device's address, so the display must be terminated before a new device can reuse
// the address. It is not shared, so terminating it is safe.
class EglOfGbm {
 public:
  explicit EglOfGbm(EGLDisplay display) : display_(display) {}
  EglOfGbm(EglOfGbm&& other) noexcept : display_(std::exchange(other.display_, EGL_NO_DISPLAY)) {}
  EglOfGbm& operator=(EglOfGbm&&) = delete;
  EglOfGbm(const EglOfGbm&) = delete;
  EglOfGbm& operator=(const EglOfGbm&) = delete;
  ~EglOfGbm() {
    if (display_ != EGL_NO_DISPLAY) eglTerminate(display_);
  }
  EGLDisplay get() const { return display_; }

 private:
  EGLDisplay display_;
};

struct Format {
  std::uint32_t fourcc;
  const char* name;
};
// ARGB is scanned out as XRGB: the card ignores the alpha byte.
constexpr std::array kFormats{Format{GBM_FORMAT_XRGB8888, "XRGB8888"}, Format{GBM_FORMAT_ARGB8888, "ARGB8888"}};

// EGL configurations give their memory format only as the native visual.
EGLConfig find_config(EGLDisplay display, std::uint32_t fourcc) {
  const std::array<EGLint, 11> wanted{EGL_RENDERABLE_TYPE,
                                      EGL_OPENGL_ES2_BIT,
                                      EGL_SURFACE_TYPE,
                                      EGL_WINDOW_BIT,
                                      EGL_RED_SIZE,
                                      8,
                                      EGL_GREEN_SIZE,
                                      8,
                                      EGL_BLUE_SIZE,
                                      8,
                                      EGL_NONE};
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted.data(), nullptr, 0, &count) || count <= 0) return nullptr;
  std::vector<EGLConfig> configs(static_cast<std::size_t>(count));
  if (!eglChooseConfig(display, wanted.data(), configs.data(), count, &count)) return nullptr;
  configs.resize(static_cast<std::size_t>(std::max(count, 0)));
  const auto found = std::ranges::find_if(configs, [&](EGLConfig config) {
    EGLint visual = 0, samples = 0;
    return eglGetConfigAttrib(display, config, EGL_NATIVE_VISUAL_ID, &visual) &&
           eglGetConfigAttrib(display, config, EGL_SAMPLES, &samples) && samples == 0 &&
           static_cast<std::uint32_t>(visual) == fourcc;
  });
  return found == configs.end() ? nullptr : *found;
}

class GbmFrame final : public ScanoutPicture {
 public:
  GbmFrame(gbm_surface* surface, gbm_bo* buffer, std::uint32_t framebuffer)
      : surface_(surface), buffer_(buffer), framebuffer_(framebuffer) {}
  GbmFrame(const GbmFrame&) = delete;
  GbmFrame& operator=(const GbmFrame&) = delete;
  ~GbmFrame() override { gbm_surface_release_buffer(surface_, buffer_); }
  std::uint32_t framebuffer() const override { return framebuffer_; }

 private:
  gbm_surface* surface_;
  gbm_bo* buffer_;
  std::uint32_t framebuffer_;
};

KmsBuffer describe(gbm_bo* buffer, std::uint32_t format) {
  KmsBuffer made;
  made.width = static_cast<int>(gbm_bo_get_width(buffer));
  made.height = static_cast<int>(gbm_bo_get_height(buffer));
  made.format = format;
  made.modifier = gbm_bo_get_modifier(buffer);
  made.has_modifier = made.modifier != kNoModifier;
  made.planes = std::clamp(gbm_bo_get_plane_count(buffer), 1, 4);
  for (int i = 0; i < made.planes; ++i) {
    const auto plane = static_cast<std::size_t>(i);
    made.handle[plane] = gbm_bo_get_handle_for_plane(buffer, i).u32;
    made.stride[plane] = gbm_bo_get_stride_for_plane(buffer, i);
    made.offset[plane] = gbm_bo_get_offset(buffer, i);
  }
  return made;
}

class EglImage {  // owns an EGLImage of a GBM buffer
 public:
  EglImage(EGLDisplay display, gbm_bo* buffer)
      : display_(display),
        image_(function<PFNEGLCREATEIMAGEKHRPROC>("eglCreateImageKHR")(
            display, EGL_NO_CONTEXT, EGL_NATIVE_PIXMAP_KHR, reinterpret_cast<EGLClientBuffer>(buffer), nullptr)) {}
  EglImage(EglImage&& other) noexcept
      : display_(other.display_), image_(std::exchange(other.image_, EGL_NO_IMAGE_KHR)) {}
  EglImage& operator=(EglImage&&) = delete;
  EglImage(const EglImage&) = delete;
  EglImage& operator=(const EglImage&) = delete;
  ~EglImage() {
    if (image_ != EGL_NO_IMAGE_KHR) function<PFNEGLDESTROYIMAGEKHRPROC>("eglDestroyImageKHR")(display_, image_);
  }
  bool show_in_bound_texture() const {
    if (image_ == EGL_NO_IMAGE_KHR) return false;
    function<PFNGLEGLIMAGETARGETTEXTURE2DOESPROC>("glEGLImageTargetTexture2DOES")(GL_TEXTURE_2D, image_);
    return true;
  }

 private:
  template <class Function>
  static Function function(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
  }
  EGLDisplay display_;
  EGLImageKHR image_;
};

class GbmPlaneBuffer final : public PlaneBuffer {
 public:
  GbmPlaneBuffer(GbmBuffer buffer, EglImage image, GlTexture texture, GlFramebuffer drawn, KmsFramebuffer shown,
                 DrawTarget target)
      : buffer_(std::move(buffer)),
        image_(std::move(image)),
        texture_(std::move(texture)),
        drawn_(std::move(drawn)),
        shown_(std::move(shown)),
        target_(target) {}
  DrawTarget target() const override { return target_; }
  std::uint32_t framebuffer() const override { return shown_.id(); }

 private:
  GbmBuffer buffer_;
  EglImage image_;
  GlTexture texture_;
  GlFramebuffer drawn_;
  KmsFramebuffer shown_;
  DrawTarget target_;
};

class GbmScanout final : public Scanout {
 public:
  GbmScanout(KmsDevice& device, GbmDevice gbm, EglOfGbm egl, GbmSurface surface, EGLSurface egl_surface,
             std::unique_ptr<GlContext> context, DrawTarget target)
      : device_(device),
        gbm_(std::move(gbm)),
        egl_(std::move(egl)),
        surface_(std::move(surface)),
        egl_surface_(egl_surface),
        context_(std::move(context)),
        target_(target) {}

  GlContext& context() override { return *context_; }
  bool has_free_buffer() const override { return gbm_surface_has_free_buffers(surface_.get()) > 0; }
  DrawTarget target() const override { return target_; }

  Result<std::unique_ptr<ScanoutPicture>> finish() override {
    if (!eglSwapBuffers(egl_.get(), egl_surface_))
      return fail(FaultKind::device, "{}: swapping buffers failed: {}", device_.path(), egl_reason());
    gbm_bo* buffer = gbm_surface_lock_front_buffer(surface_.get());
    if (buffer == nullptr) return fail(FaultKind::device, "{}: GBM returned no front buffer", device_.path());
    // GBM cycles through a few buffers; a framebuffer is kept as long as its buffer.
    auto* framebuffer = static_cast<KmsFramebuffer*>(gbm_bo_get_user_data(buffer));
    if (framebuffer == nullptr) {
      auto added = KmsFramebuffer::add(device_, describe(buffer, GBM_FORMAT_XRGB8888));
      if (!added) {
        gbm_surface_release_buffer(surface_.get(), buffer);
        return fail(FaultKind::device, "{}", added.error().what);
      }
      auto owner = std::make_unique<KmsFramebuffer>(std::move(*added));
      framebuffer = owner.get();
      gbm_bo_set_user_data(buffer, owner.release(), [](gbm_bo*, void* gone) {
        const std::unique_ptr<KmsFramebuffer> deleted(static_cast<KmsFramebuffer*>(gone));
      });
    }
    return std::make_unique<GbmFrame>(surface_.get(), buffer, framebuffer->id());
  }

  Result<std::shared_ptr<PlaneBuffer>> make_plane_buffer(int width, int height) override {
    if (!egl_offers(eglQueryString(egl_.get(), EGL_EXTENSIONS), "EGL_KHR_image_pixmap") ||
        !context_->info().has("GL_OES_EGL_image"))
      return fail(FaultKind::unsupported, "GL cannot draw into buffers for planes");
    GbmBuffer buffer(gbm_bo_create(gbm_.get(), static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                                   GBM_FORMAT_ARGB8888, GBM_BO_USE_SCANOUT | GBM_BO_USE_RENDERING));
    if (buffer == nullptr)
      return fail(FaultKind::unsupported, "GBM makes no buffer of {}x{} pixels for a plane", width, height);
    auto shown = KmsFramebuffer::add(device_, describe(buffer.get(), GBM_FORMAT_ARGB8888));
    if (!shown) return fail(FaultKind::unsupported, "{}", shown.error().what);
    EglImage image(egl_.get(), buffer.get());
    auto texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    set_filter(TextureFilter::nearest);
    if (!image.show_in_bound_texture())
      return fail(FaultKind::unsupported, "GL cannot draw into buffers for planes: {}", egl_reason());
    auto drawn = make_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, drawn.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
    if (auto whole = check_framebuffer("a buffer for a plane"); !whole)
      return fail(FaultKind::unsupported, "{}", whole.error().message);
    const DrawTarget target{drawn.name(), width, height, true};
    return std::make_shared<GbmPlaneBuffer>(std::move(buffer), std::move(image), std::move(texture), std::move(drawn),
                                            std::move(*shown), target);
  }

 private:
  KmsDevice& device_;
  GbmDevice gbm_;
  EglOfGbm egl_;
  GbmSurface surface_;
  EGLSurface egl_surface_;  // the context's
  std::unique_ptr<GlContext> context_;
  DrawTarget target_;
};

}  // namespace

Result<std::unique_ptr<Scanout>> open_gbm_scanout(KmsDevice& device, int width, int height) {
  GbmDevice gbm(gbm_create_device(device.fd()));
  if (gbm == nullptr)
    return fail(FaultKind::unsupported, "{}: GBM has no driver for it (on Debian: apt install libgl1-mesa-dri)",
                device.path());
  const auto display = open_egl_display(EGL_PLATFORM_GBM_KHR, "EGL_KHR_platform_gbm", gbm.get());
  if (!display) return fail(display.error().kind, "{}: EGL: {}", device.path(), display.error().message);
  EglOfGbm egl(*display);
  for (const Format& format : kFormats) {
    const EGLConfig config = find_config(*display, format.fourcc);
    if (config == nullptr) continue;
    GbmSurface surface(gbm_surface_create(gbm.get(), static_cast<std::uint32_t>(width),
                                          static_cast<std::uint32_t>(height), format.fourcc,
                                          GBM_BO_USE_SCANOUT | GBM_BO_USE_RENDERING));
    if (surface == nullptr) continue;
    const EGLSurface egl_surface =
        eglCreateWindowSurface(*display, config, reinterpret_cast<EGLNativeWindowType>(surface.get()), nullptr);
    if (egl_surface == EGL_NO_SURFACE) continue;
    auto context = make_egl_context(*display, config, egl_surface);
    if (!context) return fail(context.error().kind, "{}: {}", device.path(), context.error().message);
    // A window's rows: GL's row 0 is the bottom one.
    return std::make_unique<GbmScanout>(device, std::move(gbm), std::move(egl), std::move(surface), egl_surface,
                                        std::move(*context), DrawTarget{0, width, height, false});
  }
  return fail(FaultKind::unsupported, "{}: EGL and GBM share no 8-bit format for {}x{} pixels: {}", device.path(),
              width, height, egl_reason());
}

}  // namespace kasumi
