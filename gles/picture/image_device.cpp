#include "gles/picture/image_device.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "gles/gl/egl.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"
#include "gles/picture/drm_format.hpp"

namespace kasumi {
namespace {

constexpr EGLuint64KHR kLinear = 0;  // DRM_FORMAT_MOD_LINEAR

struct PlaneAttributes {
  EGLint fd, offset, pitch, modifier_low, modifier_high;
};
constexpr std::array kPlanes{
    PlaneAttributes{EGL_DMA_BUF_PLANE0_FD_EXT, EGL_DMA_BUF_PLANE0_OFFSET_EXT, EGL_DMA_BUF_PLANE0_PITCH_EXT,
                    EGL_DMA_BUF_PLANE0_MODIFIER_LO_EXT, EGL_DMA_BUF_PLANE0_MODIFIER_HI_EXT},
    PlaneAttributes{EGL_DMA_BUF_PLANE1_FD_EXT, EGL_DMA_BUF_PLANE1_OFFSET_EXT, EGL_DMA_BUF_PLANE1_PITCH_EXT,
                    EGL_DMA_BUF_PLANE1_MODIFIER_LO_EXT, EGL_DMA_BUF_PLANE1_MODIFIER_HI_EXT},
    PlaneAttributes{EGL_DMA_BUF_PLANE2_FD_EXT, EGL_DMA_BUF_PLANE2_OFFSET_EXT, EGL_DMA_BUF_PLANE2_PITCH_EXT,
                    EGL_DMA_BUF_PLANE2_MODIFIER_LO_EXT, EGL_DMA_BUF_PLANE2_MODIFIER_HI_EXT},
};

class EglImageDevice final : public ImageDevice {
 public:
  struct Calls {
    PFNEGLCREATEIMAGEKHRPROC create = nullptr;
    PFNEGLDESTROYIMAGEKHRPROC destroy = nullptr;
    PFNGLEGLIMAGETARGETTEXTURE2DOESPROC show = nullptr;
    PFNEGLQUERYDMABUFFORMATSEXTPROC formats = nullptr;  // null: the driver cannot be queried
    PFNEGLQUERYDMABUFMODIFIERSEXTPROC modifiers = nullptr;
  };
  EglImageDevice(EGLDisplay display, const Calls& calls, bool has_external)
      : display_(display), calls_(calls), has_external_(has_external) {}

  Result<> offers(std::uint32_t drm_format, ImageSampling sampling) override {
    if (sampling == ImageSampling::external && !has_external_)
      return fail(FaultKind::unsupported, "GL_OES_EGL_image_external is missing");
    if (!tells_modifiers()) return {};
    const auto formats = known_formats();
    if (std::ranges::find(formats, static_cast<EGLint>(drm_format)) == formats.end())
      return fail(FaultKind::unsupported, "the driver does not import {}", drm_format_text(drm_format));
    const auto ways = ways_of(drm_format);
    if (ways.empty()) return {};
    const auto linear = std::ranges::find(ways, kLinear, &Way::modifier);
    if (linear == ways.end())
      return fail(FaultKind::unsupported, "the driver does not import linear {}", drm_format_text(drm_format));
    if (sampling == ImageSampling::plain && linear->external_only)
      return fail(FaultKind::unsupported, "the driver imports {} for external sampling only",
                  drm_format_text(drm_format));
    return {};
  }

  Result<void*> make(const ImageRequest& request) override {
    std::vector<EGLint> attributes{EGL_LINUX_DRM_FOURCC_EXT,
                                   static_cast<EGLint>(request.drm_format),
                                   EGL_WIDTH,
                                   request.width,
                                   EGL_HEIGHT,
                                   request.height};
    const auto add = [&](EGLint name, EGLint value) { attributes.insert(attributes.end(), {name, value}); };
    const bool say_linear = tells_modifiers() && !ways_of(request.drm_format).empty();
    for (std::size_t i = 0; i < request.planes.size(); ++i) {
      add(kPlanes[i].fd, request.fd);
      add(kPlanes[i].offset, static_cast<EGLint>(request.planes[i].offset));
      add(kPlanes[i].pitch, static_cast<EGLint>(request.planes[i].stride));
      if (!say_linear) continue;
      add(kPlanes[i].modifier_low, static_cast<EGLint>(kLinear));
      add(kPlanes[i].modifier_high, static_cast<EGLint>(kLinear));
    }
    if (request.encoding) {
      const bool is_601 =
          *request.encoding == YuvEncoding::bt601_full || *request.encoding == YuvEncoding::bt601_limited;
      const bool is_full = *request.encoding == YuvEncoding::bt601_full || *request.encoding == YuvEncoding::bt709_full;
      add(EGL_YUV_COLOR_SPACE_HINT_EXT, is_601 ? EGL_ITU_REC601_EXT : EGL_ITU_REC709_EXT);
      add(EGL_SAMPLE_RANGE_HINT_EXT, is_full ? EGL_YUV_FULL_RANGE_EXT : EGL_YUV_NARROW_RANGE_EXT);
    }
    attributes.push_back(EGL_NONE);
    const EGLImageKHR image =
        calls_.create(display_, EGL_NO_CONTEXT, EGL_LINUX_DMA_BUF_EXT, nullptr, attributes.data());
    if (image == EGL_NO_IMAGE_KHR)
      return fail(FaultKind::unsupported, "the driver refuses {} of {} x {}: {}", drm_format_text(request.drm_format),
                  request.width, request.height, egl_reason());
    return image;
  }

  void destroy(void* image) override { calls_.destroy(display_, image); }

  Result<> show_in(unsigned texture, ImageSampling sampling, void* image) override {
    const GLenum target = sampling == ImageSampling::external ? GL_TEXTURE_EXTERNAL_OES : GL_TEXTURE_2D;
    glBindTexture(target, texture);
    calls_.show(target, image);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
      return fail(FaultKind::unsupported, "the driver cannot use the image as a texture (GL error {:#x})", error);
    return {};
  }

 private:
  struct Way {
    EGLuint64KHR modifier;
    bool external_only;
  };

  bool tells_modifiers() const { return calls_.formats != nullptr && calls_.modifiers != nullptr; }

  std::vector<EGLint> known_formats() const {
    EGLint count = 0;
    if (!calls_.formats(display_, 0, nullptr, &count) || count < 1) return {};
    std::vector<EGLint> formats(static_cast<std::size_t>(count));
    if (!calls_.formats(display_, count, formats.data(), &count)) return {};
    return formats;
  }

  std::vector<Way> ways_of(std::uint32_t drm_format) const {
    const auto format = static_cast<EGLint>(drm_format);
    EGLint count = 0;
    if (!calls_.modifiers(display_, format, 0, nullptr, nullptr, &count) || count < 1) return {};
    std::vector<EGLuint64KHR> modifiers(static_cast<std::size_t>(count));
    std::vector<EGLBoolean> external_only(static_cast<std::size_t>(count));
    if (!calls_.modifiers(display_, format, count, modifiers.data(), external_only.data(), &count)) return {};
    std::vector<Way> ways;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      ways.push_back({modifiers[i], external_only[i] == EGL_TRUE});
    return ways;
  }

  EGLDisplay display_;
  Calls calls_;
  bool has_external_;
};

template <class Call>
void find(Call& call, const char* name) {
  call = reinterpret_cast<Call>(eglGetProcAddress(name));
}

}  // namespace

Result<std::unique_ptr<ImageDevice>> egl_image_device(const GlInfo& info) {
  const EGLDisplay display = eglGetCurrentDisplay();
  if (display == EGL_NO_DISPLAY) return fail(FaultKind::unsupported, "the context is not an EGL context");
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  for (const char* needed : {"EGL_KHR_image_base", "EGL_EXT_image_dma_buf_import"})
    if (!egl_offers(extensions, needed)) return fail(FaultKind::unsupported, "{} is missing", needed);
  if (!info.has("GL_OES_EGL_image")) return fail(FaultKind::unsupported, "GL_OES_EGL_image is missing");
  EglImageDevice::Calls calls;
  find(calls.create, "eglCreateImageKHR");
  find(calls.destroy, "eglDestroyImageKHR");
  find(calls.show, "glEGLImageTargetTexture2DOES");
  if (egl_offers(extensions, "EGL_EXT_image_dma_buf_import_modifiers")) {
    find(calls.formats, "eglQueryDmaBufFormatsEXT");
    find(calls.modifiers, "eglQueryDmaBufModifiersEXT");
  }
  if (calls.create == nullptr || calls.destroy == nullptr || calls.show == nullptr)
    return fail(FaultKind::unsupported, "EGL offers dma-buf import, but lacks its functions");
  return std::make_unique<EglImageDevice>(display, calls, info.has("GL_OES_EGL_image_external"));
}

}  // namespace kasumi
