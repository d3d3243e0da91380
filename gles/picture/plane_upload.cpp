#include "gles/picture/plane_upload.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/picture/camera_pixels.hpp"

namespace kasumi {

Result<CameraTextures> PlaneUpload::upload(const PictureView& picture, const GlInfo& info) {
  if (auto sound = check_planes(picture); !sound) return fail(sound.error());
  if (picture.width > info.max_texture_size || picture.height > info.max_texture_size)
    return fail(FaultKind::bad_input, "camera picture: {} x {} pixels: this driver supports at most {}", picture.width,
                picture.height, info.max_texture_size);

  if (!info.highp_fragments && CameraTextures::needs_high_precision(picture.layout))
    return upload(apart(picture), info);
  CameraTextures textures{
      CameraTextures::Source::uploaded, picture.layout, picture.encoding, picture.width, picture.height, {}};
  for (int i = 0; i < plane_count(picture.layout); ++i) {
    upload_plane(picture, i, info);
    textures.names[static_cast<std::size_t>(i)] = textures_[static_cast<std::size_t>(i)].name();
  }
  if (auto uploaded = check_gl("uploading the camera's picture"); !uploaded) return fail(uploaded.error());
  return textures;
}

// Pairs of pixels as three planes.
PictureView PlaneUpload::apart(const PictureView& picture) {
  const std::size_t pairs = static_cast<std::size_t>(picture.width + 1) / 2;
  const auto rows = static_cast<std::size_t>(picture.height);
  apart_.resize(4 * pairs * rows);
  std::uint8_t* y = apart_.data();
  std::uint8_t* u = y + 2 * pairs * rows;
  std::uint8_t* v = u + pairs * rows;
  const std::size_t y_at = picture.layout == PixelLayout::yuyv ? 0 : 1, u_at = 1 - y_at;
  const PictureView planes{
      PixelLayout::i422, picture.encoding, picture.width, picture.height, {{{y, 2 * pairs}, {u, pairs}, {v, pairs}}}};
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* bytes = picture.planes[0].data + row * picture.planes[0].stride;
    for (std::size_t pair = 0; pair < pairs; ++pair, bytes += 4) {
      *y++ = bytes[y_at];
      *y++ = bytes[y_at + 2];
      *u++ = bytes[u_at];
      *v++ = bytes[u_at + 2];
    }
  }
  return planes;
}

PlaneUpload::Texels PlaneUpload::texels_of(const PictureView& picture, int plane) {
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

void PlaneUpload::upload_plane(const PictureView& picture, int index, const GlInfo& info) {
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

}  // namespace kasumi
