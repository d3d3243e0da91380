#include "gles/display/kms_device.hpp"

#include <utility>

#include <fmt/format.h>

namespace kasumi {

std::string KmsMode::text() const {
  return fmt::format("{}x{}{}@{:.2f}", width, height, interlaced ? "i" : "", refresh_hz);
}

KmsResult<KmsFramebuffer> KmsFramebuffer::add(KmsDevice& device, const KmsBuffer& buffer) {
  const auto id = device.add_framebuffer(buffer);
  if (!id) return fail(id.error());
  return KmsFramebuffer(device, *id);
}

KmsFramebuffer::KmsFramebuffer(KmsFramebuffer&& other) noexcept
    : device_(other.device_), id_(std::exchange(other.id_, 0u)) {}

KmsFramebuffer& KmsFramebuffer::operator=(KmsFramebuffer&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(id_, other.id_);
  return *this;
}

KmsFramebuffer::~KmsFramebuffer() {
  if (id_ != 0) device_->remove_framebuffer(id_);
}

}  // namespace kasumi
