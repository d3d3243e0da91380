#include "pipeline/show/scene/building_planes.hpp"

#include "gles/light/object_look.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kStill = 3;      // without noise: one is shown, and two pictures may be refused
constexpr Duration kLongestLook = 2s;  // edges and glass are exact over the background of then

bool differs(const BuildingLook& a, const BuildingLook& b) {
  return a.layer != b.layer || a.passers != b.passers || !look_alike({a.measured, a.noise}, {b.measured, b.noise});
}

}  // namespace

Result<PlaneStack> BuildingPlanes::next(Compositor& compositor, Display& display, Instant now) {
  PlaneStack picture{compositor.camera_buffer()};
  const auto look = compositor.look();
  const PixelBox all = compositor.object_box(), seen = compositor.drawn_box();
  if (!look || seen.empty()) return picture;

  const int width = all.right - all.left, height = all.bottom - all.top;
  const std::size_t count = look->noise.none() ? kStill : kNoisePatterns;
  if (width != width_ || height != height_ || count != buffers_.size()) {
    buffers_.assign(count, {});
    width_ = width;
    height_ = height;
  }
  const Duration longest = compositor.has_matte() ? Duration::zero() : kLongestLook;  // leaves move
  const auto is_stale = [&](const Buffer& buffer) {
    return !buffer.look || differs(*buffer.look, *look) || now - buffer.drawn > longest;
  };
  if (!look->noise.none() || compositor.has_matte() || is_stale(buffers_[at_ % count])) at_ = (at_ + 1) % count;
  Buffer& buffer = buffers_[at_];
  if (!buffer.buffer) {
    auto made = display.make_plane_buffer(width, height);
    if (!made) return fail(made.error());
    buffer.buffer = std::move(*made);
  }
  if (is_stale(buffer)) {
    buffer.look.reset();
    if (auto drawn = compositor.draw_for_plane(buffer.buffer->target()); !drawn) return fail(drawn.error());
    buffer.look = look;
    buffer.drawn = now;
  }
  picture.building = buffer.buffer;
  picture.left = seen.left, picture.top = seen.top, picture.right = seen.right, picture.bottom = seen.bottom;
  picture.source_left = seen.left - all.left, picture.source_top = seen.top - all.top;
  return picture;
}

}  // namespace kasumi
