#include "gles/picture/camera_input.hpp"

#include <algorithm>

namespace kasumi {
namespace {

bool same_kind(const ExternalPicture& a, const ExternalPicture& b) {
  const auto same_rows = [](const ExternalPlane& p, const ExternalPlane& q) { return p.stride == q.stride; };
  return a.layout == b.layout && a.width == b.width && a.height == b.height &&
         std::ranges::equal(a.planes, b.planes, same_rows);
}

Fault note_refusal(const Fault& why, std::vector<std::string>& notes) {
  notes.push_back(fmt::format("camera pictures are copied to the GPU: {}", why.message));
  return {FaultKind::unsupported, why.message};
}

}  // namespace

Result<> CameraInput::upload(const PictureView& frame) {
  auto textures = planes_.upload(frame, info_);
  if (!textures) return fail(textures.error());
  newest_ = *textures;
  on_gpu_ = true;
  ++frames_.uploaded;
  return {};
}

void CameraInput::keep(const PictureView& frame) {
  newest_ = {CameraTextures::Source::uploaded, frame.layout, frame.encoding, frame.width, frame.height, {}};
  on_gpu_ = false;
  ++frames_.uploaded;
}

Result<> CameraInput::upload_kept(const PictureView& frame) {
  --frames_.uploaded;
  return upload(frame);
}

Result<> CameraInput::import_frame(const ExternalPicture& frame, std::vector<std::string>& notes) {
  if (no_import_) return fail(*no_import_);
  if (import_refused_ && same_kind(*import_refused_, frame))
    return fail(FaultKind::unsupported, "import was refused before: pictures of this kind are copied");
  if (!import_) {
    auto device = open_image_device();
    if (!device) return fail(*(no_import_ = note_refusal(device.error(), notes)));
    import_.emplace(std::move(*device));
  }
  auto textures = import_->import(frame, info_);
  if (!textures) {
    if (textures.error().kind != FaultKind::unsupported) return fail(textures.error());
    import_refused_ = frame;
    return fail(note_refusal(textures.error(), notes));
  }
  newest_ = *textures;
  on_gpu_ = true;
  ++frames_.imported;
  return {};
}

void CameraInput::drop_buffers() {
  if (import_) import_->drop();
  if (newest_.source != CameraTextures::Source::uploaded) newest_ = {};
}

Result<std::unique_ptr<ImageDevice>> CameraInput::open_image_device() const {
  if (info_.software && !options_.import_on_software)
    return fail(FaultKind::unsupported, "{} is software, which may crash on other drivers' memory", info_.renderer);
  return options_.image_device ? options_.image_device(info_) : egl_image_device(info_);
}

}  // namespace kasumi
