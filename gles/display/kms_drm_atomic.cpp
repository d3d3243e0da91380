#include <array>
#include <cstring>

#include "gles/display/kms_drm.hpp"

namespace kasumi {

DrmProperties drm_properties(int fd, std::uint32_t object, std::uint32_t type) {
  DrmProperties found;
  const CPtr<drmModeObjectProperties, drmModeFreeObjectProperties> all(drmModeObjectGetProperties(fd, object, type));
  if (all == nullptr) return found;
  for (std::uint32_t i = 0; i < all->count_props; ++i) {
    const CPtr<drmModePropertyRes, drmModeFreeProperty> property(drmModeGetProperty(fd, all->props[i]));
    if (property == nullptr) continue;
    const std::string name(property->name, strnlen(property->name, sizeof property->name));
    found[name] = {property->prop_id, all->prop_values[i]};
  }
  return found;
}

const DrmProperties& DrmAtomic::properties(std::uint32_t object, std::uint32_t type) {
  const auto [place, is_new] = properties_.try_emplace(object);
  if (is_new) place->second = drm_properties(fd_, object, type);
  return place->second;
}

class DrmAtomic::Request {
 public:
  explicit Request(DrmAtomic& atomic) : atomic_(atomic), request_(drmModeAtomicAlloc()) {}
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;
  ~Request() {
    if (mode_blob_ != 0) drmModeDestroyPropertyBlob(atomic_.fd_, mode_blob_);
  }

  void set(std::uint32_t object, std::uint32_t type, const char* name, std::uint64_t value) {
    const DrmProperties& properties = atomic_.properties(object, type);
    const auto property = properties.find(name);
    if (property == properties.end() || request_ == nullptr ||
        drmModeAtomicAddProperty(request_.get(), object, property->second.id, value) < 0)
      complete_ = false;
  }
  void set_if_there(std::uint32_t object, std::uint32_t type, const char* name, std::uint64_t value) {
    if (atomic_.properties(object, type).contains(name)) set(object, type, name, value);
  }
  void set_mode(std::uint32_t crtc, const KmsMode& mode) {
    if (drmModeCreatePropertyBlob(atomic_.fd_, mode.timing.data(), mode.timing.size(), &mode_blob_) != 0)
      complete_ = false;
    set(crtc, DRM_MODE_OBJECT_CRTC, "MODE_ID", mode_blob_);
  }
  void show_nothing(std::uint32_t plane) {
    set(plane, DRM_MODE_OBJECT_PLANE, "FB_ID", 0);
    set(plane, DRM_MODE_OBJECT_PLANE, "CRTC_ID", 0);
  }

  KmsResult<> commit(const std::string& path, const char* what, std::uint32_t flags, std::uint64_t number) {
    errno = EINVAL;  // an incomplete request is not sent
    // The number is passed as the event's user data, a pointer that libdrm hands to the kernel unchanged.
    auto* user_data = reinterpret_cast<void*>(static_cast<std::uintptr_t>(number));
    if (!complete_ || drmModeAtomicCommit(atomic_.fd_, request_.get(), flags, user_data) != 0)
      return drm_error("{} on {}", what, path);
    return {};
  }

 private:
  DrmAtomic& atomic_;
  CPtr<drmModeAtomicReq, drmModeAtomicFree> request_;
  std::uint32_t mode_blob_ = 0;
  bool complete_ = true;
};

KmsResult<> DrmAtomic::commit_mode(const std::string& path, const KmsPipe& pipe, const KmsFrame& frame, KmsWait wait) {
  Request request(*this);
  // The previous DRM master may have left a cursor, an overlay or a second connector on the same CRTC.
  if (const DrmPlanes planes(drmModeGetPlaneResources(fd_)); planes != nullptr)
    for (std::uint32_t i = 0; i < planes->count_planes; ++i) {
      const DrmPlane plane(drmModeGetPlane(fd_, planes->planes[i]));
      if (plane != nullptr && plane->crtc_id == pipe.crtc && plane->plane_id != pipe.plane)
        request.show_nothing(plane->plane_id);
    }
  if (const DrmResources resources(drmModeGetResources(fd_)); resources != nullptr)
    for (int i = 0; i < resources->count_connectors; ++i) {
      const std::uint32_t other = resources->connectors[i];
      if (other == pipe.connector) continue;
      const auto current = drm_properties(fd_, other, DRM_MODE_OBJECT_CONNECTOR);
      const auto crtc = current.find("CRTC_ID");
      if (crtc != current.end() && crtc->second.value == pipe.crtc)
        request.set(other, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID", 0);
    }

  request.set(pipe.connector, DRM_MODE_OBJECT_CONNECTOR, "CRTC_ID", pipe.crtc);
  request.set_if_there(pipe.connector, DRM_MODE_OBJECT_CONNECTOR, "link-status", DRM_MODE_LINK_STATUS_GOOD);
  request.set_mode(pipe.crtc, pipe.mode);
  request.set(pipe.crtc, DRM_MODE_OBJECT_CRTC, "ACTIVE", 1);

  const auto set_plane = [&](const char* name, std::uint64_t value) {
    request.set(pipe.plane, DRM_MODE_OBJECT_PLANE, name, value);
  };
  const auto width = static_cast<std::uint64_t>(pipe.mode.width), height = static_cast<std::uint64_t>(pipe.mode.height);
  set_plane("FB_ID", frame.framebuffer);
  set_plane("CRTC_ID", pipe.crtc);
  set_plane("SRC_X", 0);
  set_plane("SRC_Y", 0);
  set_plane("SRC_W", width << 16);  // 16.16 fixed point
  set_plane("SRC_H", height << 16);
  set_plane("CRTC_X", 0);
  set_plane("CRTC_Y", 0);
  set_plane("CRTC_W", width);
  set_plane("CRTC_H", height);
  request.set_if_there(pipe.plane, DRM_MODE_OBJECT_PLANE, "rotation", DRM_MODE_ROTATE_0);

  return request.commit(
      path, "setting the mode",
      DRM_MODE_ATOMIC_ALLOW_MODESET | DRM_MODE_PAGE_FLIP_EVENT | (wait == KmsWait::no ? DRM_MODE_ATOMIC_NONBLOCK : 0u),
      frame.number);
}

KmsResult<> DrmAtomic::commit_flip(const std::string& path, const KmsPipe& pipe, const KmsFrame& frame) {
  Request request(*this);
  request.set(pipe.plane, DRM_MODE_OBJECT_PLANE, "FB_ID", frame.framebuffer);
  return request.commit(path, "page flip", DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, frame.number);
}

KmsResult<> DrmAtomic::commit_off(const std::string& path, const KmsPipe& pipe) {
  Request request(*this);
  request.set(pipe.crtc, DRM_MODE_OBJECT_CRTC, "ACTIVE", 0);
  return request.commit(path, "turning the display off", DRM_MODE_ATOMIC_ALLOW_MODESET, 0);
}

}  // namespace kasumi
