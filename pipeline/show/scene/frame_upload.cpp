#include "pipeline/show/scene/frame_upload.hpp"

namespace kasumi {

namespace {

ExternalPicture external(const PictureView& view, const DmaBuf& memory) {
  ExternalPicture picture{memory.fd, memory.buffer, view.layout, view.encoding, view.width, view.height, {}};
  for (std::size_t i = 0; i < static_cast<std::size_t>(plane_count(view.layout)); ++i)
    picture.planes[i] = {memory.offset + static_cast<std::uint32_t>(view.planes[i].data - view.planes[0].data),
                         static_cast<std::uint32_t>(view.planes[i].stride)};
  return picture;
}

}  // namespace

Result<> FrameUpload::pass(Renderer& renderer, const DecodedPicture& picture, bool dimmed) {
  if (!dimmed && picture.dma_buf() && renderer.import_frame(external(picture.view(), *picture.dma_buf()))) {
    lent_ = picture;
    lent_to_gpu_ = any_ = true;
    return {};
  }
  const PictureView& view = dimmed ? dimmed_.dim(picture.view()) : picture.view();
  if (auto uploaded = renderer.upload(view, picture.jpeg_steps()); !uploaded) return uploaded;
  lent_.reset();
  any_ = true;
  return {};
}

Result<> FrameUpload::lend(const DecodedPicture& picture) {
  const auto& view = picture.view();
  if (view.width != width_ || view.height != height_)
    return fail(FaultKind::bad_input, "camera picture of {} x {} pixels: the view is of {} x {}", view.width,
                view.height, width_, height_);
  if (!picture.dma_buf()) return fail(FaultKind::bad_input, "the camera's picture is not in a driver's buffer");
  lent_ = picture;
  lent_to_gpu_ = false;
  camera_buffer_ = external(view, *picture.dma_buf());
  any_ = true;
  return {};
}

Result<> FrameUpload::pass_lent(Renderer& renderer) {
  return lent_ && !lent_to_gpu_ ? pass(renderer, DecodedPicture(*lent_)) : Result<>{};
}

Result<> FrameUpload::release(Renderer& renderer) {
  if (!lent_) return {};
  if (auto copied = renderer.upload(lent_->view(), lent_->jpeg_steps()); !copied) return copied;
  lent_.reset();
  return {};
}

}  // namespace kasumi
