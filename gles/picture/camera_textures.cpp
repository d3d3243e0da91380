#include "gles/picture/camera_textures.hpp"

#include "gles/gl/gl.hpp"

namespace kasumi {

int CameraTextures::count() const {
  return source == Source::external ? 1 : plane_count(layout);
}

Defines CameraTextures::defines() const {
  if (source == Source::external) return {"LAYOUT_EXTERNAL"};
  const bool imported = source == Source::imported;
  switch (layout) {
    case PixelLayout::rgb8:
    case PixelLayout::rgba8: return {"LAYOUT_RGB"};
    case PixelLayout::grey8: return {imported ? "LAYOUT_GREY" : "LAYOUT_RGB"};
    case PixelLayout::bgr8:
    case PixelLayout::bgra8: return {"LAYOUT_BGR"};
    case PixelLayout::yuyv: return {"LAYOUT_YUYV"};
    case PixelLayout::uyvy: return {"LAYOUT_UYVY"};
    case PixelLayout::nv12: return imported ? Defines{"LAYOUT_NV12", "CHROMA_IN_GREEN"} : Defines{"LAYOUT_NV12"};
    case PixelLayout::i420:
    case PixelLayout::i422:
    case PixelLayout::i444: return {"LAYOUT_PLANAR"};
  }
  return {};
}

void CameraTextures::bind(const Program& program, bool smooth) const {
  // Two pixels share a texel of the packed layouts: filtering would mix their luma.
  const bool packed = source != Source::external && (layout == PixelLayout::yuyv || layout == PixelLayout::uyvy);
  const GLint filter = smooth && !packed ? GL_LINEAR : GL_NEAREST;
  const GLenum target = source == Source::external ? GL_TEXTURE_EXTERNAL_OES : GL_TEXTURE_2D;
  constexpr std::array<std::string_view, 3> kNames{"plane_0", "plane_1", "plane_2"};
  for (int i = 0; i < count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(target, names[at]);
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    program.set(kNames[at], i);
  }
  const YuvToRgb yuv = yuv_to_rgb(encoding);
  program.set("yuv_offset", glm::dvec3(yuv.offset));
  program.set("yuv_to_rgb", glm::transpose(glm::dmat3(yuv.rows[0], yuv.rows[1], yuv.rows[2])));
  const double half_width = (width + 1) / 2, half_height = (height + 1) / 2;
  program.set("packed_size", glm::dvec2{width, half_width});
  const bool whole_width = layout == PixelLayout::i444;
  const bool whole_height = whole_width || layout == PixelLayout::i422;
  program.set("chroma_scale", glm::dvec2{whole_width ? 1.0 : width / (2.0 * half_width),
                                         whole_height ? 1.0 : height / (2.0 * half_height)});
}

}  // namespace kasumi
