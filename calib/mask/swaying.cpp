#include "calib/mask/swaying.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

// ln of light; what counts as another detail, between these, six times the noise.
constexpr float kLeastChange = 0.12F, kMostNeeded = 0.35F;
constexpr int kFewestEpisodes = 3;  // of another detail, for something that sways
constexpr int kRareReach_px = 12;   // from there, what is seldom covered belongs to it
constexpr int kClosing_px = 6;      // gaps of it that are closed
constexpr int kFewestPixels = 30;
constexpr double kLargestIsland = 0.04;  // of the picture: still parts within it

// The deviation that noise does not make, by a pixel's ln of light: from the quietest pixels as bright.
class Noise {
 public:
  explicit Noise(const PictureSeries& series) {
    std::array<std::vector<float>, kLevels> deviations;
    for_each_detail(series, [&](int x, int y, const std::vector<float>& detail, float level) {
      if ((x + y) % 3 != 0) return;
      const float middle = median(detail);
      std::vector<float> off;
      for (const float value : detail) off.push_back(value - middle);
      deviations[bin(level)].push_back(robust_sigma(std::move(off)));
    });
    for (std::size_t i = 0; i < kLevels; ++i)
      change_[i] = std::clamp(6.0F * quantile_in_place(deviations[i], 0.1), kLeastChange, kMostNeeded);
  }
  float change(float level) const { return change_[bin(level)]; }

 private:
  static constexpr std::size_t kLevels = 16;
  static std::size_t bin(float level) {
    const float share = (level - std::log(kFaintestLight)) / -std::log(kFaintestLight);
    return static_cast<std::size_t>(std::clamp(share * kLevels, 0.0F, kLevels - 1.0F));
  }
  std::array<float, kLevels> change_{};
};

}  // namespace

cv::Mat disc_of(int radius_px) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius_px + 1, 2 * radius_px + 1});
}

void keep_large(cv::Mat1b& of, double least) {
  cv::Mat labels, statistics, centres;
  cv::connectedComponentsWithStats(of, labels, statistics, centres, 8, CV_32S);
  for (int y = 0; y < of.rows; ++y)
    for (int x = 0; x < of.cols; ++x)
      if (of(y, x) != 0 && statistics.at<int>(labels.at<int>(y, x), cv::CC_STAT_AREA) < least) of(y, x) = 0;
}

cv::Mat1b swaying(const PictureSeries& series, const cv::Rect& box) {
  const Noise noise(series);
  cv::Mat1b often(series.height(), series.width(), std::uint8_t{0}), ever = often.clone();
  for_each_detail(series, [&](int x, int y, const std::vector<float>& detail, float level) {
    if (!box.contains({x, y})) return;
    const float middle = median(detail), change = noise.change(level);
    int episodes = 0, pictures = 0;
    bool other = false;
    for (const float value : detail) {
      const bool before = other;
      other = std::abs(value - middle) > change;
      pictures += other;
      episodes += other && !before;
    }
    if (episodes >= kFewestEpisodes) often(y, x) = 255;
    if (pictures > 0) ever(y, x) = 255;
  });
  keep_large(often, kFewestPixels);
  cv::Mat1b near, found;
  cv::dilate(often, near, disc_of(kRareReach_px));
  cv::bitwise_and(ever, near, found);
  cv::bitwise_or(found, often, found);
  cv::morphologyEx(found, found, cv::MORPH_CLOSE, disc_of(kClosing_px));
  // Still parts that are not large are islands in it.
  cv::Mat1b still;
  cv::bitwise_not(found, still);
  keep_large(still, kLargestIsland * found.rows * found.cols);
  cv::bitwise_not(still, found);
  cv::Mat1b in_box(found.size(), std::uint8_t{0});
  in_box(box).setTo(255);
  cv::bitwise_and(found, in_box, found);
  return found;
}

}  // namespace kasumi
