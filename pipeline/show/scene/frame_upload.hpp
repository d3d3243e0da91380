// How the camera's pictures reach the GPU: copied, or read in the driver's buffers.
#pragma once

#include <optional>

#include "capture/codec/dimmed_picture.hpp"
#include "capture/frame.hpp"
#include "gles/composite/renderer.hpp"

namespace kasumi {

// Belongs to the renderer that it is always given.
class FrameUpload {
 public:
  FrameUpload(int width, int height) : width_(width), height_(height) {}

  // Errors: as Renderer::upload().
  Result<> pass(Renderer& renderer, const DecodedPicture& picture, bool dimmed = false);
  // Only keeps the picture, for a display that shows it by itself. Errors: bad_input (another size, or not in a
  // driver's buffer).
  Result<> lend(const DecodedPicture& picture);
  // Passes the lent picture, unless the GPU has it.
  Result<> pass_lent(Renderer& renderer);
  // Copies a picture that still lies in the driver's buffer, which releases the buffer.
  Result<> release(Renderer& renderer);

  bool any() const { return any_; }                                        // passed or lent
  const ExternalPicture& camera_buffer() const { return camera_buffer_; }  // of the picture lent last

 private:
  int width_, height_;                  // of the camera's pictures
  std::optional<DecodedPicture> lent_;  // the last picture, while it uses the driver's buffer
  bool lent_to_gpu_ = false;            // else to the display alone
  ExternalPicture camera_buffer_;
  DimmedPicture dimmed_;
  bool any_ = false;
};

}  // namespace kasumi
