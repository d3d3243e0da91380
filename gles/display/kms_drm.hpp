// Shared by the sources that use libdrm. For gles/display/kms_drm*.cpp only.
#pragma once

#include <cerrno>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "base/c_ptr.hpp"
#include "gles/display/kms_device.hpp"

namespace kasumi {

using DrmResources = CPtr<drmModeRes, drmModeFreeResources>;
using DrmConnector = CPtr<drmModeConnector, drmModeFreeConnector>;
using DrmEncoder = CPtr<drmModeEncoder, drmModeFreeEncoder>;
using DrmPlanes = CPtr<drmModePlaneRes, drmModeFreePlaneResources>;
using DrmPlane = CPtr<drmModePlane, drmModeFreePlane>;
using DrmCrtc = CPtr<drmModeCrtc, drmModeFreeCrtc>;
using DrmBlob = CPtr<drmModePropertyBlobRes, drmModeFreePropertyBlob>;

// The error of the last failed call, from errno.
template <class... Args>
tl::unexpected<KmsError> drm_error(fmt::format_string<Args...> what, Args&&... args) {
  const auto code = static_cast<std::errc>(errno);
  return tl::unexpected<KmsError>(KmsError{code, fmt::format("{}: {}", fmt::format(what, std::forward<Args>(args)...),
                                                             std::make_error_code(code).message())});
}

struct DrmProperty {
  std::uint32_t id = 0;
  std::uint64_t value = 0;
  std::map<std::string, std::uint64_t, std::less<>> choices{};  // of an enumeration
  std::uint64_t least = 0, most = 0;                            // of a range
  bool fixed = false;
};
// By name; empty where the object has none. `type` is DRM_MODE_OBJECT_PLANE and the like.
using DrmProperties = std::map<std::string, DrmProperty, std::less<>>;
DrmProperties drm_properties(int fd, std::uint32_t object, std::uint32_t type);

// The names that the kernel gives the ways to read YUV.
struct DrmYuvNames {
  const char* encoding;
  const char* range;
};
DrmYuvNames drm_yuv_names(YuvEncoding encoding);

// The commits of kms_device.hpp as atomic requests of object properties.
class DrmAtomic {
 public:
  explicit DrmAtomic(int fd) : fd_(fd) {}
  KmsResult<> commit_mode(const std::string& path, const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait);
  KmsResult<> commit_flip(const std::string& path, const KmsPipe& pipe, const KmsFrame& frame);
  KmsResult<> commit_planes(const std::string& path, const KmsPipe& pipe, std::span<const KmsPlaneState> planes,
                            std::uint64_t number, KmsTrial trial);
  KmsResult<> commit_off(const std::string& path, const KmsPipe& pipe);

 private:
  int fd_;
  std::map<std::uint32_t, DrmProperties> properties_;  // their ids do not change while the card is open
  const DrmProperties& properties(std::uint32_t object, std::uint32_t type);
  class Request;
};

}  // namespace kasumi
