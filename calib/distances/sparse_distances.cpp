#include "calib/distances/sparse_distances.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr double kDense = 0.6;         // of the neighbours of known pixels
constexpr double kUsualGap = 0.9;      // of the gaps are no wider
constexpr double kWidestInGaps = 4.0;  // usual gaps

cv::Mat1b known_pixels(const Image<float>& metres) {
  cv::Mat1b known(metres.height(), metres.width());
  for (int y = 0; y < metres.height(); ++y)
    for (int x = 0; x < metres.width(); ++x)
      known(y, x) = metres.at(x, y) > 0.0F && std::isfinite(metres.at(x, y)) ? 255 : 0;
  return known;
}

double share_of_neighbours(const cv::Mat1b& known) {
  double neighbours = 0.0, pixels = 0.0;
  for (int y = 1; y + 1 < known.rows; ++y)
    for (int x = 1; x + 1 < known.cols; ++x) {
      if (!known(y, x)) continue;
      ++pixels;
      for (const int j : {-1, 0, 1})
        for (const int i : {-1, 0, 1}) neighbours += (i != 0 || j != 0) && known(y + j, x + i) ? 1.0 : 0.0;
    }
  return pixels > 0.0 ? neighbours / (8.0 * pixels) : 1.0;
}

// For each pixel how far the nearest known one is, and which.
class NearestKnown {
 public:
  explicit NearestKnown(const cv::Mat1b& known) {
    cv::distanceTransform(known == 0, away_px_, label_, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    for (int y = 0; y < known.rows; ++y)
      for (int x = 0; x < known.cols; ++x) {
        if (!known(y, x)) continue;
        const auto label = static_cast<std::size_t>(label_(y, x));
        if (label >= place_.size()) place_.resize(label + 1);
        place_[label] = {x, y};
      }
  }
  float away_px(int x, int y) const { return away_px_(y, x); }
  cv::Point place(int x, int y) const { return place_[static_cast<std::size_t>(label_(y, x))]; }

 private:
  cv::Mat1f away_px_;
  cv::Mat1i label_;
  std::vector<cv::Point> place_;
};

// The topmost known row of the columns around each; the picture's height where there is none.
std::vector<int> topmost_rows(const cv::Mat1b& known, int reach_px) {
  std::vector<int> own(static_cast<std::size_t>(known.cols), known.rows), around = own;
  for (int y = known.rows - 1; y >= 0; --y)
    for (int x = 0; x < known.cols; ++x)
      if (known(y, x)) own[static_cast<std::size_t>(x)] = y;
  for (int x = 0; x < known.cols; ++x)
    for (int i = std::max(0, x - reach_px); i <= std::min(known.cols - 1, x + reach_px); ++i)
      around[static_cast<std::size_t>(x)] =
          std::min(around[static_cast<std::size_t>(x)], own[static_cast<std::size_t>(i)]);
  return around;
}

// How far the pixels between points are from them, but for the widest gaps.
double usual_gap_px(const cv::Mat1b& known, const NearestKnown& nearest) {
  const auto top = topmost_rows(known, 0);
  std::vector<float> gaps;
  for (int y = 0; y < known.rows; ++y)
    for (int x = 0; x < known.cols; ++x)
      if (!known(y, x) && y > top[static_cast<std::size_t>(x)]) gaps.push_back(nearest.away_px(x, y));
  if (gaps.empty()) return 1.0;
  const auto at = gaps.begin() + static_cast<std::ptrdiff_t>(kUsualGap * static_cast<double>(gaps.size() - 1));
  std::nth_element(gaps.begin(), at, gaps.end());
  return static_cast<double>(*at);
}

}  // namespace

std::string fill_sparse(Image<float>& metres) {
  const auto known = known_pixels(metres);
  const int count = cv::countNonZero(known);
  if (count == 0 || share_of_neighbours(known) >= kDense) return {};
  const NearestKnown nearest(known);
  const double gap_px = usual_gap_px(known, nearest);
  const auto top = topmost_rows(known, static_cast<int>(std::ceil(gap_px)));
  int filled = 0;
  const auto measured = metres;
  for (int y = 0; y < known.rows; ++y)
    for (int x = 0; x < known.cols; ++x) {
      if (known(y, x) || y < top[static_cast<std::size_t>(x)] ||
          static_cast<double>(nearest.away_px(x, y)) > kWidestInGaps * gap_px)
        continue;
      if (std::isinf(metres.at(x, y))) continue;  // sky is known to be sky
      const auto from = nearest.place(x, y);
      metres.at(x, y) = measured.at(from.x, from.y);
      ++filled;
    }
  const double percent = 100.0 / static_cast<double>(known.total());
  return fmt::format(
      "sparse, as a lidar's: {:.1f} % of the pixels measured, {:.1f} % filled from the nearest, up to {:.0f} px away",
      percent * count, percent * filled, kWidestInGaps * gap_px);
}

void fill_small_holes(Image<float>& metres, double smallest_sky_share) {
  cv::Mat1b holes(metres.height(), metres.width());
  for (int y = 0; y < metres.height(); ++y)
    for (int x = 0; x < metres.width(); ++x) holes(y, x) = metres.at(x, y) == 0.0F ? 255 : 0;
  const auto known = known_pixels(metres);
  if (cv::countNonZero(holes) == 0 || cv::countNonZero(known) == 0) return;
  cv::Mat labels, stats, centres;
  cv::connectedComponentsWithStats(holes, labels, stats, centres, 8, CV_32S);
  const NearestKnown nearest(known);
  const auto measured = metres;
  for (int y = 0; y < holes.rows; ++y)
    for (int x = 0; x < holes.cols; ++x) {
      if (!holes(y, x)) continue;
      const int area = stats.at<int>(labels.at<int>(y, x), cv::CC_STAT_AREA);
      if (area >= smallest_sky_share * static_cast<double>(holes.total())) continue;
      const auto from = nearest.place(x, y);
      metres.at(x, y) = measured.at(from.x, from.y);
    }
}

}  // namespace kasumi
