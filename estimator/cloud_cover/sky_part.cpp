#include "estimator/cloud_cover/sky_part.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/nth_smallest.hpp"

namespace kasumi {

namespace {

constexpr float kSharp = 0.2f;       // ln of encoded values, over two elements
constexpr float kRimZenith = 85.0f;  // degrees
constexpr float kGreen = 0.07f;      // greenness that no sky has, however bright

cv::Mat1b sharp_edges(const PixelFeatures& sky) {
  cv::Mat smooth, logs;
  cv::GaussianBlur(sky.rgb, smooth, {3, 3}, 0);
  cv::log(smooth + cv::Scalar::all(0.06), logs);
  const cv::Mat3f& l = static_cast<const cv::Mat3f&>(logs);
  cv::Mat1b edges(cv::Mat1b::zeros(l.size()));
  for (int y = 1; y + 1 < l.rows; ++y) {
    const cv::Vec3f *above = l[y - 1], *here = l[y], *below = l[y + 1];
    const auto* inside = sky.inside[y];
    auto* edge = edges[y];
    for (int x = 1; x + 1 < l.cols; ++x) {
      float across = 0.0f, down = 0.0f;
      for (int c = 0; c < 3; ++c) {
        across = std::max(across, std::abs(here[x + 1][c] - here[x - 1][c]));
        down = std::max(down, std::abs(below[x][c] - above[x][c]));
      }
      edge[x] = across * across + down * down >= kSharp * kSharp ? inside[x] : std::uint8_t{0};
    }
  }
  return edges;
}

// The area free of sharp edges that is largest, weighted with its light; with a margin.
cv::Mat1b open_sky(const PixelFeatures& sky, const cv::Mat& brush) {
  cv::Mat near_edge;
  cv::dilate(sharp_edges(sky), near_edge, brush);
  const cv::Mat1b free(sky.inside & ~near_edge);
  cv::Mat1i label;
  const int areas = cv::connectedComponents(free, label, 4, CV_32S);
  std::vector<double> sum(static_cast<std::size_t>(areas), 0.0);
  for (int y = 0; y < label.rows; ++y)
    for (int x = 0; x < label.cols; ++x)
      if (label(y, x) > 0) sum[static_cast<std::size_t>(label(y, x))] += static_cast<double>(sky.light(y, x)) + 0.05;
  const int main = static_cast<int>(std::max_element(sum.begin(), sum.end()) - sum.begin());
  cv::Mat1b open(cv::Mat1b::zeros(label.size()));
  if (main > 0) open.setTo(255, label == main);
  cv::Mat grown;
  cv::dilate(open, grown, brush);
  return cv::Mat1b(grown & sky.inside);
}

// Whether an area cut off from the open sky is something else than cloud.
bool is_before_sky(const PixelFeatures& sky, const cv::Mat1b& area, const cv::Mat1b& open, const cv::Rect& box,
                   float open_light, int reach) {
  const cv::Rect wide = cv::Rect(box.x - reach, box.y - reach, box.width + 2 * reach, box.height + 2 * reach) &
                        cv::Rect(0, 0, area.cols, area.rows);
  cv::Mat grown;
  cv::dilate(area(wide), grown, cv::Mat1b(reach, reach, static_cast<uchar>(1)));
  std::vector<float> beside, light, blue;
  int rim = 0, odd = 0, bluish = 0;
  for (int y = wide.y; y < wide.y + wide.height; ++y)
    for (int x = wide.x; x < wide.x + wide.width; ++x) {
      if (grown.at<uchar>(y - wide.y, x - wide.x) && open(y, x)) beside.push_back(sky.light(y, x));
      if (!area(y, x)) continue;
      rim += sky.zenith_deg(y, x) > kRimZenith;
      light.push_back(sky.light(y, x));
      const float b = sky.blueness(y, x);
      blue.push_back(b);
      bluish += b > 0.2f;
      odd += (b < -0.03f) + (sky.greenness(y, x) > 0.03f);
    }
  if (rim < 0.06 * sky.radius) return false;
  const auto share = [&](int n) { return static_cast<double>(n) / static_cast<double>(light.size()); };
  const float sky_light = beside.size() > 20 ? quantile_in_place(beside, 0.5) : open_light;
  const double darker = std::log((quantile_in_place(light, 0.5) + 0.03f) / (sky_light + 0.03f));
  const bool dark = darker < -0.15 || (darker < -0.03 && quantile_in_place(blue, 0.8) < 0.18f);
  return (share(bluish) < 0.2 && dark) || (share(odd) > 0.4 && share(bluish) < 0.35);
}

// Of the marked elements those that are connected to the rim.
cv::Mat1b reaching_in(const PixelFeatures& sky, const cv::Mat1b& marked) {
  cv::Mat1i label;
  const int areas = cv::connectedComponents(marked, label, 8, CV_32S);
  std::vector<char> rim(static_cast<std::size_t>(areas), 0);
  for (int y = 0; y < label.rows; ++y)
    for (int x = 0; x < label.cols; ++x)
      if (sky.zenith_deg(y, x) > kRimZenith) rim[static_cast<std::size_t>(label(y, x))] = 1;
  cv::Mat1b kept(cv::Mat1b::zeros(label.size()));
  for (int y = 0; y < label.rows; ++y)
    for (int x = 0; x < label.cols; ++x)
      if (label(y, x) > 0 && rim[static_cast<std::size_t>(label(y, x))]) kept(y, x) = 255;
  return kept;
}

}  // namespace

cv::Mat1b not_sky(const PixelFeatures& sky) {
  const int side = scaled_side(sky, 7);
  const cv::Mat brush = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  const cv::Mat1b open = open_sky(sky, brush);
  cv::Mat1b marked(cv::Mat1b::zeros(sky.inside.size()));
  if (cv::countNonZero(open) == 0) return marked;

  std::vector<float> lights;
  for (int y = 0; y < open.rows; ++y)
    for (int x = 0; x < open.cols; ++x)
      if (open(y, x)) lights.push_back(sky.light(y, x));
  const float open_light = counted_quantile(lights, 0.5);

  cv::Mat1b rest(sky.inside & ~open);
  cv::morphologyEx(rest, rest, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  cv::Mat1i label, box;
  cv::Mat1d middle;
  const int areas = cv::connectedComponentsWithStats(rest, label, box, middle, 8, CV_32S);
  for (int i = 1; i < areas; ++i) {
    if (box(i, cv::CC_STAT_AREA) < 0.002 * sky.count) continue;
    const cv::Mat1b area(label == i);
    const cv::Rect around(box(i, cv::CC_STAT_LEFT), box(i, cv::CC_STAT_TOP), box(i, cv::CC_STAT_WIDTH),
                          box(i, cv::CC_STAT_HEIGHT));
    if (is_before_sky(sky, area, open, around, open_light, 2 * side + 7)) marked |= area;
  }

  const InsideMeans means(sky.inside, 5);
  const cv::Mat1f light = means.of(sky.light), green = means.of(sky.greenness), blue = means.of(sky.blueness);
  const float somewhat = (open_light + 0.03f) * std::exp(-0.25f) - 0.03f;
  const float much = (open_light + 0.03f) * std::exp(-1.3f) - 0.03f;
  for (int y = 0; y < marked.rows; ++y)
    for (int x = 0; x < marked.cols; ++x) {
      if (!sky.inside(y, x)) continue;
      const bool odd = light(y, x) < somewhat && (green(y, x) > 0.04f || blue(y, x) < -0.08f);
      if (odd || green(y, x) > kGreen || (light(y, x) < much && sky.blueness(y, x) < 0.12f)) marked(y, x) = 255;
    }
  return reaching_in(sky, marked);
}

}  // namespace kasumi
