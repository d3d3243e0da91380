// Between the scene and the sky (H Sect 4.1): where foliage ends, neither picture nor range can be relied on, and a
// hard edge of the haze would show. The range goes over into the sky's smoothly there; what was measured stays as it
// is.
#include <cmath>

#include <glm/vec2.hpp>
#include <opencv2/imgproc.hpp>

#include "estimator/haze_range.hpp"

namespace kasumi {
namespace {

// H makes about 2 mu Jacobi steps. Over-relaxed (Young 1954), as many reach a hundredth of their error.
int sweeps_for(int margin_px) {
  return 4 * margin_px + 8;
}
double over_relaxation(int margin_px) {
  return 2.0 / (1.0 + std::sin(3.141592653589793 / (margin_px + 1.0)));
}

}  // namespace

void taper_into_sky(Image<float>& range, const Image<std::uint8_t>& sky, float sky_range, int margin_px) {
  if (margin_px < 1 || range.empty()) return;
  auto copy = sky.elements();
  cv::Mat distance;
  cv::distanceTransform(cv::Mat(sky.height(), sky.width(), CV_8U, copy.data()), distance, cv::DIST_L2,
                        cv::DIST_MASK_PRECISE);
  std::vector<glm::ivec2> margin;
  for (int y = 0; y < sky.height(); ++y)
    for (int x = 0; x < sky.width(); ++x)
      if (sky.at(x, y) != 0 && distance.at<float>(y, x) < static_cast<float>(margin_px)) {
        margin.push_back({x, y});
        range.at(x, y) = sky_range;
      }
  const auto relax = static_cast<float>(over_relaxation(margin_px));
  for (int sweep = 0; sweep < sweeps_for(margin_px); ++sweep)
    for (const auto& p : margin) {
      float sum = 0.0F, count = 0.0F;
      for (const glm::ivec2 u : {glm::ivec2{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (range.contains(p.x + u.x, p.y + u.y)) {
          sum += range.at(p.x + u.x, p.y + u.y);
          count += 1.0F;
        }
      float& here = range.at(p.x, p.y);
      here += relax * (sum / count - here);
    }
}

}  // namespace kasumi
