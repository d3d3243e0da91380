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

Result<std::unique_ptr<CameraSource>> open_libcamera_source(const LibcameraOptions&, Clock&) {
  return missing();
}

}  // namespace kasumi
