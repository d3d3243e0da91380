#include "gles/picture/plane_import.hpp"

#include <unistd.h>

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/picture/drm_format.hpp"

namespace kasumi {
namespace {

// Buffers unused for this many pictures belong to an earlier opening of the camera.
constexpr std::uint64_t kForgottenAfter = 32;

constexpr std::uint32_t kR8 = drm_format("R8  "), kRg8 = drm_format("GR88"), kRgba8 = drm_format("AB24"),
                        kRgb8 = drm_format("BG24");

ImageRequest plane_request(const ExternalPicture& p, int plane) {
  const PlaneSize size = plane_size(p.layout, p.width, p.height, plane);
  const auto bytes = static_cast<int>(size.row_bytes);
  const std::vector<ExternalPlane> rows{p.planes[static_cast<std::size_t>(plane)]};
  switch (p.layout) {
    case PixelLayout::rgb8:
    case PixelLayout::bgr8: return {kRgb8, bytes / 3, size.rows, p.fd, rows};
    case PixelLayout::rgba8:
    case PixelLayout::bgra8:
    case PixelLayout::yuyv:
    case PixelLayout::uyvy: return {kRgba8, bytes / 4, size.rows, p.fd, rows};
    case PixelLayout::nv12:
      if (plane == 1) return {kRg8, bytes / 2, size.rows, p.fd, rows};
      break;
    case PixelLayout::grey8:
    case PixelLayout::i420:
    case PixelLayout::i422:
    case PixelLayout::i444: break;
  }
  return {kR8, bytes, size.rows, p.fd, rows};
}

std::vector<ImageRequest> requests(CameraTextures::Source source, const ExternalPicture& p) {
  const auto planes = static_cast<std::size_t>(plane_count(p.layout));
  if (source == CameraTextures::Source::external) {
    const std::optional<YuvEncoding> encoding = is_yuv(p.layout) ? std::optional(p.encoding) : std::nullopt;
    return {{drm_format_of(p.layout),
             p.width,
             p.height,
             p.fd,
             {p.planes.begin(), p.planes.begin() + static_cast<std::ptrdiff_t>(planes)},
             encoding}};
  }
  std::vector<ImageRequest> all;
  for (std::size_t i = 0; i < planes; ++i) all.push_back(plane_request(p, static_cast<int>(i)));
  return all;
}

// Drivers may not check the layout and read beyond the memory.
Result<> check(const ExternalPicture& p, const GlInfo& info) {
  if (p.width < 1 || p.height < 1 || p.width > info.max_texture_size || p.height > info.max_texture_size)
    return fail(FaultKind::bad_input, "camera buffer of {} x {} pixels: expected 1 to {} a side", p.width, p.height,
                info.max_texture_size);
  const off_t bytes = lseek(p.fd, 0, SEEK_END);
  if (bytes < 0) return fail(FaultKind::unsupported, "the camera's buffer does not report its size");
  Problems problems;
  for (int i = 0; i < plane_count(p.layout); ++i) {
    const ExternalPlane& plane = p.planes[static_cast<std::size_t>(i)];
    const PlaneSize size = plane_size(p.layout, p.width, p.height, i);
    const std::uint64_t end =
        plane.offset + std::uint64_t{plane.stride} * static_cast<std::uint64_t>(size.rows - 1) + size.row_bytes;
    if (plane.stride < size.row_bytes || end > static_cast<std::uint64_t>(bytes) || end > INT32_MAX)
      problems.add("camera buffer ({}, {} x {}): plane {} at {} with rows of {} bytes does not fit {} bytes",
                   name_of(p.layout), p.width, p.height, i, plane.offset, plane.stride, bytes);
  }
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

}  // namespace

Result<PlaneImport::Imported> PlaneImport::import_as(CameraTextures::Source source, const ExternalPicture& picture) {
  const bool external = source == CameraTextures::Source::external;
  if (external && picture.layout == PixelLayout::grey8)
    return fail(FaultKind::unsupported, "grey cannot be sampled as an external picture");
  const auto sampling = external ? ImageSampling::external : ImageSampling::plain;
  const GLenum target = external ? GL_TEXTURE_EXTERNAL_OES : GL_TEXTURE_2D;
  Imported made{picture, source, {}, 0};
  for (const ImageRequest& request : requests(source, picture)) {
    if (auto offered = device_->offers(request.drm_format, sampling); !offered) return fail(offered.error());
    auto image = device_->make(request);
    if (!image) return fail(image.error());
    made.planes.push_back({make_texture(), Image(*device_, *image)});
    const Plane& plane = made.planes.back();
    if (auto shown = device_->show_in(plane.texture.name(), sampling, plane.image.get()); !shown)
      return fail(shown.error());
    glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  return made;
}

Result<CameraTextures> PlaneImport::import(const ExternalPicture& picture, const GlInfo& info) {
  glActiveTexture(GL_TEXTURE0);
  auto known = imported_.find(picture.buffer);
  if (known != imported_.end() && !same_place(known->second.picture, picture)) {
    imported_.erase(known);
    known = imported_.end();
  }
  if (known == imported_.end()) {
    if (auto whole = check(picture, info); !whole) return fail(whole.error());
    const bool readable = info.highp_fragments || !CameraTextures::needs_high_precision(picture.layout);
    auto made = readable ? import_as(CameraTextures::Source::imported, picture)
                         : fail(FaultKind::unsupported, "{} needs shaders of high precision", name_of(picture.layout));
    if (!made) {
      auto external = import_as(CameraTextures::Source::external, picture);
      if (!external) return fail(FaultKind::unsupported, "{}; {}", made.error().message, external.error().message);
      made = std::move(external);
    }
    known = imported_.emplace(picture.buffer, std::move(*made)).first;
  } else {
    // Attached again for each picture, so that no cache keeps the buffer's previous contents.
    const auto sampling =
        known->second.source == CameraTextures::Source::external ? ImageSampling::external : ImageSampling::plain;
    for (const Plane& plane : known->second.planes)
      if (auto shown = device_->show_in(plane.texture.name(), sampling, plane.image.get()); !shown)
        return fail(shown.error());
  }
  Imported& now = known->second;
  now.used = ++imports_;
  std::erase_if(imported_, [&](const auto& entry) { return entry.second.used + kForgottenAfter < imports_; });

  CameraTextures textures{now.source, picture.layout, picture.encoding, picture.width, picture.height, {}};
  for (std::size_t i = 0; i < now.planes.size(); ++i) textures.names[i] = now.planes[i].texture.name();
  return textures;
}

}  // namespace kasumi
