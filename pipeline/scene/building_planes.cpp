#include "pipeline/scene/building_planes.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kNoisy = 6;      // patterns of noise in turn
constexpr std::size_t kStill = 3;      // without noise: one is shown, and two pictures may be refused
constexpr Duration kLongestLook = 2s;  // edges and glass are exact over the background of then
constexpr double kHalfAStep = 0.004;   // of 8 bits, relative to linear light
constexpr double kOtherNoise = 0.05;   // relative

bool differs(const glm::dvec3& a, const glm::dvec3& b, double relative) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(a[c] - b[c]) > relative * std::max(std::abs(a[c]), std::abs(b[c]))) return true;
  return false;
}

bool differs(const BuildingLook& a, const BuildingLook& b) {
  if (a.layer != b.layer || a.passers != b.passers || a.measured.first_px != b.measured.first_px ||
      a.measured.last_px != b.measured.last_px || differs(a.noise.shot, b.noise.shot, kOtherNoise) ||
      differs(a.noise.read, b.noise.read, kOtherNoise))
    return true;
  return !std::ranges::equal(a.measured.light, b.measured.light,
                             [](const glm::dvec3& p, const glm::dvec3& q) { return !differs(p, q, kHalfAStep); });
}

}  // namespace

Result<PlanePicture> BuildingPlanes::next(Compositor& compositor, Display& display, Instant now) {
  PlanePicture picture{compositor.camera_buffer()};
  const auto look = compositor.look();
  const PixelBox all = compositor.object_box(), seen = compositor.drawn_box();
  if (!look || seen.empty()) return picture;

  const int width = all.right - all.left, height = all.bottom - all.top;
  const std::size_t count = look->noise.none() ? kStill : kNoisy;
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
