#include "base/photograph.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kasumi {

Image<Rgb8> to_rgb8(const Photograph& photograph) {
  const auto& encoded = photograph.encoded;
  Image<Rgb8> picture(encoded.width(), encoded.height());
  std::transform(encoded.elements().begin(), encoded.elements().end(), picture.elements().begin(),
                 [](const glm::vec3& v) {
                   Rgb8 pixel;
                   for (int c = 0; c < 3; ++c)
                     pixel[c] = static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(v[c], 0.0f, 1.0f)));
                   return pixel;
                 });
  return picture;
}

}  // namespace kasumi
