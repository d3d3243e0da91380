// Pictures of one scene in order of time, as light of one exposure and white balance.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/statistics.hpp"
#include "calib/camera.hpp"

namespace kasumi {

constexpr float kFaintestLight = 0.01F;  // of full scale, added to all light: a step in the dark is not a large ratio
inline const glm::vec3 kLumaWeights{0.299F, 0.587F, 0.114F};  // luma's weights

// The pictures' light, all brought to the exposure and white balance of the middle one. They must outlive it.
class PictureSeries {
 public:
  PictureSeries(std::span<const Image<Rgb8>> pictures, const Response& response);
  std::size_t size() const { return pictures_.size(); }
  int width() const { return pictures_.front().width(); }
  int height() const { return pictures_.front().height(); }
  glm::vec3 at(std::size_t t, int x, int y) const;
  std::vector<glm::vec3> over_time(int x, int y) const;

 private:
  float light(const Rgb8& pixel, int c) const { return table_[static_cast<std::size_t>(c)][pixel[c]]; }

  std::span<const Image<Rgb8>> pictures_;
  std::array<std::array<float, 256>, 3> table_;  // light of codes, never 0
  std::vector<glm::vec3> gains_;
};

// Calls use(x, y, detail of the pixel over time: ln of light over its mean in 7 x 7 pixels; its median ln of light) for
// all pixels, some rows at a time.
template <class Use>
void for_each_detail(const PictureSeries& series, Use use) {
  constexpr int kRows = 32, kDetail_px = 7, kMargin = kDetail_px / 2;
  std::vector<cv::Mat1f> details(series.size()), levels(series.size());
  std::vector<float> over_time(series.size()), level(series.size());
  for (int first = 0; first < series.height(); first += kRows) {
    const int end = std::min(series.height(), first + kRows);
    const int from = std::max(0, first - kMargin), to = std::min(series.height(), end + kMargin);
    for (std::size_t t = 0; t < series.size(); ++t) {
      levels[t].create(to - from, series.width());
      for (int y = from; y < to; ++y)
        for (int x = 0; x < series.width(); ++x)
          levels[t](y - from, x) = std::log(glm::dot(kLumaWeights, series.at(t, x, y)));
      cv::blur(levels[t], details[t], {kDetail_px, kDetail_px});
      details[t] = levels[t] - details[t];
    }
    for (int y = first; y < end; ++y)
      for (int x = 0; x < series.width(); ++x) {
        for (std::size_t t = 0; t < series.size(); ++t) {
          over_time[t] = details[t](y - from, x);
          level[t] = levels[t](y - from, x);
        }
        use(x, y, over_time, median_in_place(level));
      }
  }
}

}  // namespace kasumi
