#include "gles/display/kms_camera_buffers.hpp"

namespace kasumi {
namespace {

// Buffers unused for this many pictures belong to an earlier opening of the camera.
constexpr std::uint64_t kForgottenAfter = 32;

}  // namespace

Result<std::shared_ptr<const KmsFramebuffer>> KmsCameraBuffers::import(const ExternalPicture& picture) {
  auto known = imported_.find(picture.buffer);
  if (known == imported_.end() || !same_place(known->second.picture, picture)) {
    KmsBuffer buffer;
    buffer.width = picture.width;
    buffer.height = picture.height;
    buffer.format = drm_format_of(picture.layout);
    buffer.modifier = 0;  // linear
    buffer.has_modifier = true;
    buffer.planes = plane_count(picture.layout);
    buffer.dma_buf = picture.fd;
    for (std::size_t i = 0; i < static_cast<std::size_t>(buffer.planes); ++i) {
      buffer.stride[i] = picture.planes[i].stride;
      buffer.offset[i] = picture.planes[i].offset;
    }
    auto added = KmsFramebuffer::add(device_, buffer);
    if (!added) return fail(FaultKind::unsupported, "{}", added.error().what);
    Imported made{picture, std::make_shared<const KmsFramebuffer>(std::move(*added)), 0};
    known = imported_.insert_or_assign(picture.buffer, std::move(made)).first;
  }
  known->second.used = ++imports_;
  const auto framebuffer = known->second.framebuffer;
  std::erase_if(imported_, [&](const auto& entry) { return entry.second.used + kForgottenAfter < imports_; });
  return framebuffer;
}

}  // namespace kasumi
