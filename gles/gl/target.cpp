#include "gles/gl/target.hpp"

#include <cstdint>

namespace kasumi {

Letterbox letterbox(const DrawTarget& target, int picture_width, int picture_height) {
  if (target.width <= 0 || target.height <= 0 || picture_width <= 0 || picture_height <= 0) return {};
  const std::int64_t tw = target.width, th = target.height, pw = picture_width, ph = picture_height;
  const bool bars_left_and_right = tw * ph > th * pw;
  Letterbox box;
  box.width = bars_left_and_right ? static_cast<int>((th * pw + ph / 2) / ph) : target.width;
  box.height = bars_left_and_right ? target.height : static_cast<int>((tw * ph + pw / 2) / pw);
  box.x = (target.width - box.width) / 2;
  box.y = (target.height - box.height) / 2;
  return box;
}

}  // namespace kasumi
