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
    DrmProperty& made = found[name];
    made.id = property->prop_id;
    made.value = all->prop_values[i];
    made.fixed = (property->flags & DRM_MODE_PROP_IMMUTABLE) != 0;
    for (int choice = 0; choice < property->count_enums; ++choice) {
      const drm_mode_property_enum& one = property->enums[choice];
      made.choices[std::string(one.name, strnlen(one.name, sizeof one.name))] = one.value;
    }
    if (drm_property_type_is(property.get(), DRM_MODE_PROP_RANGE) && property->count_values == 2) {
      made.least = property->values[0];
      made.most = property->values[1];
    }
  }
  return found;
}

DrmYuvNames drm_yuv_names(YuvEncoding encoding) {
  const bool is_601 = encoding == YuvEncoding::bt601_full || encoding == YuvEncoding::bt601_limited;
  const bool is_full = encoding == YuvEncoding::bt601_full || encoding == YuvEncoding::bt709_full;
  return {is_601 ? "ITU-R BT.601 YCbCr" : "ITU-R BT.709 YCbCr", is_full ? "YCbCr full range" : "YCbCr limited range"};
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
  // One of an enumeration's choices, where the driver has that property.
  void choose(std::uint32_t plane, const char* name, const char* choice) {
    const DrmProperties& properties = atomic_.properties(plane, DRM_MODE_OBJECT_PLANE);
    const auto property = properties.find(name);
    if (property == properties.end() || property->second.fixed) return;
    const auto value = property->second.choices.find(choice);
    if (value == property->second.choices.end())
      complete_ = false;
    else
      set(plane, DRM_MODE_OBJECT_PLANE, name, value->second);
  }
  void show(std::uint32_t crtc, const KmsPlaneState& state) {
    const auto set_plane = [&](const char* name, std::uint64_t value) {
      set(state.plane, DRM_MODE_OBJECT_PLANE, name, value);
    };
    const auto wide = [](int pixels) { return static_cast<std::uint64_t>(pixels); };
    set_plane("FB_ID", state.framebuffer);
    set_plane("CRTC_ID", crtc);
    set_plane("SRC_X", wide(state.source.x) << 16);  // 16.16 fixed point
    set_plane("SRC_Y", wide(state.source.y) << 16);
    set_plane("SRC_W", wide(state.source.width) << 16);
    set_plane("SRC_H", wide(state.source.height) << 16);
    set_plane("CRTC_X", wide(state.x));
    set_plane("CRTC_Y", wide(state.y));
    set_plane("CRTC_W", wide(state.source.width));
    set_plane("CRTC_H", wide(state.source.height));
    set_if_there(state.plane, DRM_MODE_OBJECT_PLANE, "rotation", DRM_MODE_ROTATE_0);
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

  request.show(pipe.crtc, {pipe.plane, frame.framebuffer, {0, 0, pipe.mode.width, pipe.mode.height}});

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

KmsResult<> DrmAtomic::commit_planes(const std::string& path, const KmsPipe& pipe,
                                     std::span<const KmsPlaneState> planes, std::uint64_t number, KmsTrial trial) {
  Request request(*this);
  for (const KmsPlaneState& state : planes) {
    if (state.framebuffer == 0) {
      request.show_nothing(state.plane);
      continue;
    }
    request.show(pipe.crtc, state);
    request.set_if_there(state.plane, DRM_MODE_OBJECT_PLANE, "alpha", 0xffff);
    if (state.blends) request.choose(state.plane, "pixel blend mode", "Pre-multiplied");
    if (state.zpos) request.set(state.plane, DRM_MODE_OBJECT_PLANE, "zpos", *state.zpos);
    if (state.encoding) {
      const auto names = drm_yuv_names(*state.encoding);
      request.choose(state.plane, "COLOR_ENCODING", names.encoding);
      request.choose(state.plane, "COLOR_RANGE", names.range);
    }
  }
  const bool asks = trial == KmsTrial::only_ask;
  return request.commit(path, asks ? "asking for planes" : "showing planes",
                        asks ? DRM_MODE_ATOMIC_TEST_ONLY : DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, number);
}

KmsResult<> DrmAtomic::commit_off(const std::string& path, const KmsPipe& pipe) {
  Request request(*this);
  request.set(pipe.crtc, DRM_MODE_OBJECT_CRTC, "ACTIVE", 0);
  return request.commit(path, "turning the display off", DRM_MODE_ATOMIC_ALLOW_MODESET, 0);
}

}  // namespace kasumi
