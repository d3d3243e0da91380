#include "tests/estimator/passers/clips.hpp"

#include <algorithm>
#include <stdexcept>

namespace kasumi {

const PassersLook& Clip::show(Passers& watch, double seconds, const Before& before) {
  cutout_ = fixtures::Cutout(kClipWidth, kClipHeight, glm::vec4{0.0F});
  if (before) before(cutout_, seconds);
  const bool empty = std::ranges::all_of(cutout_.elements(), [](const auto& pixel) { return pixel.a == 0.0F; });
  if (empty) {
    auto& filmed = empty_[seconds];
    if (filmed.empty()) filmed = land_.film(seconds);
    picture_ = filmed;
  } else {
    picture_ = land_.film(seconds, &cutout_);
  }
  if (spoil) spoil(picture_, seconds);
  if (jpeg_quality >= 100) return watch.look(view_of(picture_), at(seconds));
  const auto frame = encode_frame(picture_, parse_four_cc("MJPG").value(), {.jpeg_quality = jpeg_quality});
  if (!frame) throw std::runtime_error(frame.error().message);
  const auto decoded = decode(*frame, YuvEncoding::bt601_full);
  if (!decoded) throw std::runtime_error(decoded.error().message);
  return watch.look(decoded->view(), at(seconds));
}

OutlineErrors Clip::errors(const PassersLook& look) const {
  OutlineErrors found;
  for (int y = 0; y < kClipHeight; ++y)
    for (int x = 0; x < kClipWidth; ++x) {
      if (!is_building(x, y)) continue;
      found.building_px += 1.0;
      const auto& pixels = look.in_front.pixels;
      const int u = x - look.in_front.left, v = y - look.in_front.top;
      const double left_out = pixels.contains(u, v) ? 1.0 - pixels.at(u, v).a / 255.0 : 0.0;
      const auto covered = static_cast<double>(cutout_.at(x, y).a);
      found.passer_px += covered;
      found.drawn_over += std::max(0.0, covered - left_out);
      found.false_px += std::max(0.0, left_out - covered);
    }
  if (found.passer_px > 0.0) {
    found.drawn_over /= found.passer_px;
    found.halo = found.false_px / found.passer_px;
  }
  return found;
}

void settle(Clip& clip, Passers& watch, double seconds, double period_s) {
  for (double t = 0.0; t < seconds; t += period_s) clip.show(watch, t);
}

}  // namespace kasumi
