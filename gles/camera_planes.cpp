#include "gles/camera_planes.hpp"

#include <algorithm>

#include "gles/gl.hpp"

namespace kasumi {

Result<> CameraPlanes::upload(const PictureView& picture, const GlInfo& info) {
  Problems problems;
  if (picture.width < 1 || picture.height < 1)
    problems.add("camera picture: {} x {} pixels: expected at least 1 x 1", picture.width, picture.height);
  if (picture.width > info.max_texture_size || picture.height > info.max_texture_size)
    problems.add("camera picture: {} x {} pixels: this driver takes {} at most", picture.width, picture.height,
                 info.max_texture_size);
  if (!problems.empty()) return fail(problems.fault());
  for (int i = 0; i < plane_count(picture.layout); ++i) {
    const Plane& plane = picture.planes[static_cast<std::size_t>(i)];
    const PlaneSize size = plane_size(picture.layout, picture.width, picture.height, i);
    if (plane.data == nullptr) problems.add("camera picture ({}): plane {} is missing", name_of(picture.layout), i);
    if (plane.stride < size.row_bytes)
      problems.add("camera picture ({}): plane {} has a stride of {} bytes: expected at least {}",
                   name_of(picture.layout), i, plane.stride, size.row_bytes);
  }
  if (!problems.empty()) return fail(problems.fault());

  layout_ = picture.layout;
  encoding_ = picture.encoding;
  width_ = picture.width;
  height_ = picture.height;
  for (int i = 0; i < plane_count(layout_); ++i) upload_plane(picture, i, info);
  return check_gl("uploading the camera's picture");
}

CameraPlanes::Texels CameraPlanes::texels_of(const PictureView& picture, int plane) {
  const int half_width = (picture.width + 1) / 2;
  const int rows = plane_size(picture.layout, picture.width, picture.height, plane).rows;
  switch (picture.layout) {
    case PixelLayout::rgb8:
    case PixelLayout::bgr8: return {GL_RGB, 3, picture.width, rows};
    case PixelLayout::rgba8:
    case PixelLayout::bgra8: return {GL_RGBA, 4, picture.width, rows};
    case PixelLayout::yuyv:
    case PixelLayout::uyvy: return {GL_RGBA, 4, half_width, rows};
    case PixelLayout::nv12:
      if (plane == 1) return {GL_LUMINANCE_ALPHA, 2, half_width, rows};
      return {GL_LUMINANCE, 1, picture.width, rows};
    case PixelLayout::i420:
    case PixelLayout::i422: return {GL_LUMINANCE, 1, plane == 0 ? picture.width : half_width, rows};
    case PixelLayout::grey8:
    case PixelLayout::i444: return {GL_LUMINANCE, 1, picture.width, rows};
  }
  return {};
}

void CameraPlanes::upload_plane(const PictureView& picture, int index, const GlInfo& info) {
  const auto at = static_cast<std::size_t>(index);
  const Texels texels = texels_of(picture, index);
  const std::uint8_t* rows = picture.planes[at].data;
  const std::size_t stride = picture.planes[at].stride;
  const std::size_t row_bytes = texels.bytes * static_cast<std::size_t>(texels.width);

  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const bool gaps = stride != row_bytes;
  const bool skip_gaps = gaps && stride % texels.bytes == 0 && info.has("GL_EXT_unpack_subimage");
  if (skip_gaps) {
    glPixelStorei(GL_UNPACK_ROW_LENGTH_EXT, static_cast<GLint>(stride / texels.bytes));
  } else if (gaps) {
    packed_.resize(row_bytes * static_cast<std::size_t>(texels.height));
    for (std::size_t y = 0; y < static_cast<std::size_t>(texels.height); ++y)
      std::copy_n(rows + y * stride, row_bytes, packed_.data() + y * row_bytes);
    rows = packed_.data();
  }

  if (!textures_[at]) textures_[at] = make_texture();
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(index));
  glBindTexture(GL_TEXTURE_2D, textures_[at].name());
  if (held_[at] == texels) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, texels.width, texels.height, texels.format, GL_UNSIGNED_BYTE, rows);
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(texels.format), texels.width, texels.height, 0, texels.format,
                 GL_UNSIGNED_BYTE, rows);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    held_[at] = texels;
  }
  if (skip_gaps) glPixelStorei(GL_UNPACK_ROW_LENGTH_EXT, 0);
}

std::string CameraPlanes::define() const {
  switch (layout_) {
    case PixelLayout::rgb8:
    case PixelLayout::rgba8:
    case PixelLayout::grey8: return "LAYOUT_RGB";
    case PixelLayout::bgr8:
    case PixelLayout::bgra8: return "LAYOUT_BGR";
    case PixelLayout::yuyv: return "LAYOUT_YUYV";
    case PixelLayout::uyvy: return "LAYOUT_UYVY";
    case PixelLayout::nv12: return "LAYOUT_NV12";
    case PixelLayout::i420:
    case PixelLayout::i422:
    case PixelLayout::i444: return "LAYOUT_PLANAR";
  }
  return {};
}

void CameraPlanes::bind(const Program& program, bool smooth) const {
  // Two pixels share a texel of the packed layouts: filtering would mix their luma.
  const bool packed = layout_ == PixelLayout::yuyv || layout_ == PixelLayout::uyvy;
  const GLint filter = smooth && !packed ? GL_LINEAR : GL_NEAREST;
  constexpr std::array<std::string_view, 3> kNames{"plane_0", "plane_1", "plane_2"};
  for (int i = 0; i < plane_count(layout_); ++i) {
    const auto at = static_cast<std::size_t>(i);
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(GL_TEXTURE_2D, textures_[at].name());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    program.set(kNames[at], i);
  }
  const YuvToRgb yuv = yuv_to_rgb(encoding_);
  program.set("yuv_offset", glm::dvec3(yuv.offset));
  program.set("yuv_to_rgb", glm::transpose(glm::dmat3(yuv.rows[0], yuv.rows[1], yuv.rows[2])));
  const double half_width = (width_ + 1) / 2, half_height = (height_ + 1) / 2;
  program.set("packed_size", glm::dvec2{width_, half_width});
  const bool whole_width = layout_ == PixelLayout::i444;
  const bool whole_height = whole_width || layout_ == PixelLayout::i422;
  program.set("chroma_scale", glm::dvec2{whole_width ? 1.0 : width_ / (2.0 * half_width),
                                         whole_height ? 1.0 : height_ / (2.0 * half_height)});
}

}  // namespace kasumi
