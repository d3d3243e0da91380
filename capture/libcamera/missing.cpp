// Stubs for builds without libcamera.
#include "capture/libcamera/libcamera_source.hpp"

namespace kasumi {

namespace {

tl::unexpected<Fault> missing() {
  return fail(FaultKind::unsupported,
              "this build has no libcamera (on Debian: apt install libcamera-dev, and build again)");
}

}  // namespace

Result<std::vector<LibcameraListing>> list_libcamera_cameras() {
  return missing();
}

bool is_libcamera_camera_present(const std::string&) {
  return false;
}

Result<std::unique_ptr<CameraSource>> open_libcamera_source(const LibcameraOptions&, Clock&) {
  return missing();
}

}  // namespace kasumi
