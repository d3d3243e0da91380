#include "calib/mask/rim_surround.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include <opencv2/imgproc.hpp>

namespace kasumi {

cv::Mat1b surround_of(const cv::Mat3f& tones, double reach) {
  cv::Mat1b mask(tones.rows + 2, tones.cols + 2, std::uint8_t{0});
  const int inset = std::max(1, std::min(tones.cols, tones.rows) / 100);
  const std::array corners{cv::Point{inset, inset}, cv::Point{tones.cols - 1 - inset, inset},
                           cv::Point{inset, tones.rows - 1 - inset},
                           cv::Point{tones.cols - 1 - inset, tones.rows - 1 - inset}};
  const cv::Scalar range(reach, reach, reach);
  cv::Mat3f unchanged = tones;
  for (const auto& corner : corners)
    if (mask(corner.y + 1, corner.x + 1) == 0)
      cv::floodFill(unchanged, mask, corner, {}, nullptr, range, range,
                    4 | cv::FLOODFILL_FIXED_RANGE | cv::FLOODFILL_MASK_ONLY | (255 << 8));
  return mask(cv::Rect(1, 1, tones.cols, tones.rows));
}

}  // namespace kasumi
