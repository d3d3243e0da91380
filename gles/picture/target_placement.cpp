#include "gles/picture/target_placement.hpp"

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

glm::dmat3 to_clip(double w, double h, double up) {
  return glm::dmat3({2.0 / w, 0.0, 0.0}, {0.0, up * 2.0 / h, 0.0}, {1.0 / w - 1.0, up * (1.0 / h - 1.0), 1.0});
}

}  // namespace

TargetPlacement::TargetPlacement(const DrawTarget& target, int width, int height)
    : box(letterbox(target, width, height)), picture(width, height), top_row_first(target.top_row_first) {
  const double up = target.top_row_first ? 1.0 : -1.0;
  same_size = box.width == width && box.height == height;
  pixel_to_clip = to_clip(width, height, up);
  const double bw = box.width, bh = box.height;
  fragment_to_picture = glm::dmat3({1.0 / bw, 0.0, 0.0}, {0.0, up / bh, 0.0},
                                   {-box.x / bw, target.top_row_first ? -box.y / bh : 1.0 + box.y / bh, 1.0});
}

TargetPlacement::TargetPlacement(const PixelBox& part, int width, int height)
    : box{-part.left, -part.top, width, height}, picture(width, height), pixel_to_clip(to_clip(width, height, 1.0)) {}

void TargetPlacement::begin(const DrawTarget& target, bool with_depth) const {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glViewport(box.x, box.y, box.width, box.height);
  const bool bars = box.width != target.width || box.height != target.height;
  glClearColor(0, 0, 0, 1);
  if (bars || with_depth) glClear((bars ? GL_COLOR_BUFFER_BIT : 0u) | (with_depth ? GL_DEPTH_BUFFER_BIT : 0u));
}

}  // namespace kasumi
