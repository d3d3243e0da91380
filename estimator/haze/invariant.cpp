#include <algorithm>
#include <cmath>

#include "estimator/haze/passes.hpp"

namespace kasumi {

void invariant_pass(const Image<glm::vec4>& from, const Image<float>& rate, double inner_px, int k,
                    Image<glm::vec4>& to) {
  const int width = from.width(), height = from.height();
  // Bilinear, as a GPU's filter reads; clamped to the edge.
  const auto between = [&](const auto& image, float x, float y) {
    x = std::clamp(x, 0.0F, static_cast<float>(width - 1));
    y = std::clamp(y, 0.0F, static_cast<float>(height - 1));
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const int right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
    const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
    return (image.at(left, top) * (1.0F - u) + image.at(right, top) * u) * (1.0F - v) +
           (image.at(left, bottom) * (1.0F - u) + image.at(right, bottom) * u) * v;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float own_rate = rate.at(x, y);
      const float d = static_cast<float>(inner_px) * std::exp(static_cast<float>(k) * own_rate);
      const glm::vec4 own = from.at(x, y);
      glm::vec4 sum = own;
      const auto flow = [&](float ux, float uy) {
        const float nx = static_cast<float>(x) + ux, ny = static_cast<float>(y) + uy;
        sum += 0.5F * (own_rate + between(rate, nx, ny)) * (between(from, nx, ny) - own);
      };
      flow(d, 0.0F);
      flow(-d, 0.0F);
      flow(0.0F, d);
      flow(0.0F, -d);
      to.at(x, y) = sum;
    }
}

}  // namespace kasumi
