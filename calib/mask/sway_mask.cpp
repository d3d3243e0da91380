#include "calib/mask/sway_mask.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "calib/mask/behind.hpp"
#include "calib/mask/picture_series.hpp"
#include "calib/mask/swaying.hpp"

namespace kasumi {
namespace {

constexpr int kSpeck_px = 12;    // less than a leaf: noise
constexpr int kNear_px = 3;      // how far a pixel looks for others of its kinds, to each side
constexpr int kRim_px = 5;       // around it: the area examined, corners included
constexpr double kSharp = 0.05;  // of what was never or always covered, that noise and clouds make
constexpr double kNever = 0.01, kAlways = 0.97;

// Mean share of the pixel that is covered; less than .06 or more than .94 of it is noise or leaves of another brightness.
double covered_share(const std::vector<glm::vec3>& light, const glm::vec3& behind, const glm::vec3& front) {
  const glm::vec3 towards = front - behind;
  const float size2 = glm::dot(kLumaWeights * towards, towards);
  double sum = 0.0;
  for (const auto& value : light) {
    const double share = static_cast<double>(glm::dot(kLumaWeights * towards, value - behind) / size2);
    sum += share < 0.06 ? 0.0 : share > 0.94 ? 1.0 : share;
  }
  return sum / static_cast<double>(light.size());
}

// A pixel's share estimated again, where its surroundings are neither all free nor all covered: between nearby pure
// background and pure foreground, since the pixel itself may never be either. `first`: the shares as found at first,
// 0..1.
double refined_share(const PictureSeries& series, const Image<PixelKinds>& kinds, const Behind& behind,
                     const cv::Mat1d& first, int x, int y) {
  glm::vec3 back(0.0F), front(0.0F);
  float backs = 0.0F, fronts = 0.0F;
  double low = 1.0, high = 0.0;
  for (int v = std::max(0, y - kNear_px); v <= std::min(first.rows - 1, y + kNear_px); ++v)
    for (int u = std::max(0, x - kNear_px); u <= std::min(first.cols - 1, x + kNear_px); ++u) {
      const double share = first(v, u);
      if (std::max(std::abs(u - x), std::abs(v - y)) <= 1) low = std::min(low, share), high = std::max(high, share);
      const PixelKinds& both = kinds.at(u, v);
      if (behind.known(u, v)) {
        const auto weight = static_cast<float>(std::pow(1.0 - share, 4.0));
        back += weight * glm::exp(behind.at(u, v)), backs += weight;
      }
      if (behind.known(u, v) && !both.two) continue;
      const auto weight = static_cast<float>(std::pow(share, 4.0));
      front += weight * glm::exp(behind.known(u, v) && both.dark == behind.at(u, v) ? both.bright : both.dark);
      fronts += weight;
    }
  if (low == high || backs < 0.5F || fronts < 0.5F) return first(y, x);
  const double share = covered_share(series.over_time(x, y), back / backs, front / fronts);
  return std::abs(share - first(y, x)) < kSharp && (first(y, x) == 0.0 || first(y, x) == 1.0) ? first(y, x) : share;
}

}  // namespace

SwayMask find_sway_mask(std::span<const Image<Rgb8>> pictures, const Response& response,
                        const std::optional<glm::ivec4>& box) {
  SwayMask found;
  if (pictures.empty()) return found;
  const int width = pictures.front().width(), height = pictures.front().height();
  const cv::Rect whole(0, 0, width, height), within = box ? cv::Rect(box->x, box->y, box->z, box->w) & whole : whole;
  found.typical = Image<Rgb8>(width, height);
  std::vector<std::uint8_t> codes(pictures.size());
  for (std::size_t i = 0; i < found.typical.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      for (std::size_t t = 0; t < pictures.size(); ++t) codes[t] = pictures[t].elements()[i][c];
      found.typical.elements()[i][c] = median_in_place(codes);
    }
  const PictureSeries series(pictures, response);
  const cv::Mat1b sways = swaying(series, within);
  if (cv::countNonZero(sways) == 0) return found;

  cv::Mat1b rim;
  cv::dilate(sways, rim, disc_of(kRim_px));
  Image<PixelKinds> kinds(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (sways(y, x) != 0)
        kinds.at(x, y) = kinds_of(series.over_time(x, y));
      else if (rim(y, x) != 0)
        kinds.at(x, y).dark = median_of(series.over_time(x, y));
  const Behind behind(kinds, sways);

  cv::Mat1d first(height, width, 0.0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (sways(y, x) == 0) continue;
      const PixelKinds& both = kinds.at(x, y);
      if (!behind.known(x, y)) {
        first(y, x) = 1.0;
      } else if (both.two) {
        const bool leaf_is_dark = both.bright == behind.at(x, y);
        first(y, x) = covered_share(series.over_time(x, y), glm::exp(behind.at(x, y)),
                                    glm::exp(leaf_is_dark ? both.dark : both.bright));
      }
    }
  cv::Mat1d covered = first.clone();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (sways(y, x) != 0) covered(y, x) = refined_share(series, kinds, behind, first, x, y);
  cv::Mat1b ever;
  cv::compare(covered, kNever, ever, cv::CMP_GE);
  keep_large(ever, kSpeck_px);

  found.mask = Image<std::uint8_t>(width, height, 255);
  std::int64_t moving = 0;
  double hidden = 0.0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (ever(y, x) == 0) continue;
      hidden += covered(y, x);
      const bool always = covered(y, x) > kAlways;
      if (!always) ++moving;
      found.mask.at(x, y) =
          always ? 0 : static_cast<std::uint8_t>(std::clamp(std::lround(255.0 * (1.0 - covered(y, x))), 1L, 254L));
    }
  found.moving_share = static_cast<double>(moving) / within.area();
  found.hidden_share = hidden / within.area();
  if (moving == 0) found.mask = {};
  return found;
}

void add_still(SwayMask& sways, const Image<std::uint8_t>& still) {
  for (std::size_t i = 0; i < still.elements().size(); ++i) {
    std::uint8_t& pixel = sways.mask.elements()[i];
    if (pixel == 0 || pixel == 255) pixel = std::min(pixel, still.elements()[i]);
  }
}

}  // namespace kasumi
