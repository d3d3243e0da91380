#include "calib/mask/sway_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr float kFaintest = 0.01F;  // of full scale, added to all light: a step in the dark is not a large ratio
constexpr int kDetail_px = 7;       // across
// ln of light; what counts as another detail, between these, six times the noise.
constexpr float kLeastChange = 0.12F, kMostNeeded = 0.35F;
constexpr int kFewestEpisodes = 3;  // of another detail, for something that sways
constexpr int kRareReach_px = 12;   // from there, what is seldom covered belongs to it
constexpr int kClosing_px = 6;      // gaps of it that are closed
constexpr int kFewestPixels = 30;
constexpr int kSpeck_px = 12;            // less than a leaf: noise
constexpr double kLargestIsland = 0.04;  // of the picture: still parts within it
constexpr int kNear_px = 3;              // how far a pixel looks for others of its kinds, to each side
constexpr int kRim_px = 5;               // around it: all that is looked at so, corners included
constexpr float kAlike = 0.3F;           // ln of light: two neighbours of what is behind
constexpr float kTwoKinds = 0.25F;       // ln of light: of what is behind and what sways
constexpr double kSharp = 0.05;          // of what was never or always covered, that noise and clouds make
constexpr double kNever = 0.01, kAlways = 0.97;
const glm::vec3 kSeen{0.299F, 0.587F, 0.114F};

using LightOfCode = std::array<std::array<float, 256>, 3>;

LightOfCode light_of_codes(const Response& response) {
  LightOfCode table{};
  for (std::size_t i = 0; i < 256; ++i) {
    const auto light = response.to_light(glm::dvec3(static_cast<double>(i) / 255.0));
    for (int c = 0; c < 3; ++c)
      table[static_cast<std::size_t>(c)][i] = std::max(0.0F, static_cast<float>(light[c])) + kFaintest;
  }
  return table;
}

// The pictures' light, all brought to the exposure and white balance of the middle one.
class Series {
 public:
  Series(std::span<const Image<Rgb8>> pictures, const Response& response)
      : pictures_(pictures), table_(light_of_codes(response)), gains_(pictures.size(), glm::vec3(1.0F)) {
    const auto& reference = pictures[pictures.size() / 2];
    for (std::size_t t = 0; t < pictures.size(); ++t)
      for (int c = 0; c < 3; ++c) {
        std::vector<float> ratios;
        for (std::size_t i = 0; i < reference.elements().size(); i += 37)
          ratios.push_back(light(reference.elements()[i], c) / light(pictures[t].elements()[i], c));
        gains_[t][c] = median_in_place(ratios);
      }
  }
  std::size_t size() const { return pictures_.size(); }
  int width() const { return pictures_.front().width(); }
  int height() const { return pictures_.front().height(); }
  glm::vec3 at(std::size_t t, int x, int y) const {
    const Rgb8& pixel = pictures_[t].at(x, y);
    return gains_[t] * glm::vec3(light(pixel, 0), light(pixel, 1), light(pixel, 2));
  }
  std::vector<glm::vec3> over_time(int x, int y) const {
    std::vector<glm::vec3> values;
    for (std::size_t t = 0; t < size(); ++t) values.push_back(at(t, x, y));
    return values;
  }

 private:
  float light(const Rgb8& pixel, int c) const { return table_[static_cast<std::size_t>(c)][pixel[c]]; }

  std::span<const Image<Rgb8>> pictures_;
  LightOfCode table_;
  std::vector<glm::vec3> gains_;
};

// Calls use(x, y, details of the pixel over time, its median ln of light) for all pixels, some rows at a time.
template <class Use>
void for_each_detail(const Series& series, Use use) {
  constexpr int kRows = 32, kMargin = kDetail_px / 2;
  std::vector<cv::Mat1f> details(series.size()), levels(series.size());
  std::vector<float> over_time(series.size()), level(series.size());
  for (int first = 0; first < series.height(); first += kRows) {
    const int end = std::min(series.height(), first + kRows);
    const int from = std::max(0, first - kMargin), to = std::min(series.height(), end + kMargin);
    for (std::size_t t = 0; t < series.size(); ++t) {
      levels[t].create(to - from, series.width());
      for (int y = from; y < to; ++y)
        for (int x = 0; x < series.width(); ++x) levels[t](y - from, x) = std::log(glm::dot(kSeen, series.at(t, x, y)));
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

// The deviation that noise does not make, by a pixel's ln of light: from the quietest pixels as bright.
class Noise {
 public:
  explicit Noise(const Series& series) {
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
    const float share = (level - std::log(kFaintest)) / -std::log(kFaintest);
    return static_cast<std::size_t>(std::clamp(share * kLevels, 0.0F, kLevels - 1.0F));
  }
  std::array<float, kLevels> change_{};
};

cv::Mat disc(int radius_px) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius_px + 1, 2 * radius_px + 1});
}

// Keeps the connected parts of at least `least` pixels.
void keep_large(cv::Mat1b& of, double least) {
  cv::Mat labels, statistics, centres;
  cv::connectedComponentsWithStats(of, labels, statistics, centres, 8, CV_32S);
  for (int y = 0; y < of.rows; ++y)
    for (int x = 0; x < of.cols; ++x)
      if (of(y, x) != 0 && statistics.at<int>(labels.at<int>(y, x), cv::CC_STAT_AREA) < least) of(y, x) = 0;
}

// Where something sways, and what that encloses: 255.
cv::Mat1b swaying(const Series& series, const cv::Rect& box) {
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
  cv::dilate(often, near, disc(kRareReach_px));
  cv::bitwise_and(ever, near, found);
  cv::bitwise_or(found, often, found);
  cv::morphologyEx(found, found, cv::MORPH_CLOSE, disc(kClosing_px));
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

// A pixel's pictures in one kind, or in two: ln of light.
struct Kinds {
  glm::vec3 dark{0.0F}, bright{0.0F};
  bool two = false;
};

glm::vec3 median_of(const std::vector<glm::vec3>& light) {
  glm::vec3 middle;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (const auto& value : light) values.push_back(std::log(value[c]));
    middle[c] = median_in_place(values);
  }
  return middle;
}

Kinds kinds_of(const std::vector<glm::vec3>& light) {
  std::vector<float> seen;
  for (const auto& value : light) seen.push_back(std::log(glm::dot(kSeen, value)));
  float low = quantile(seen, 0.02), high = quantile(seen, 0.98);
  for (int round = 0; round < 8; ++round) {
    float sums[2]{}, counts[2]{};
    for (const float value : seen) {
      const int kind = value > 0.5F * (low + high) ? 1 : 0;
      sums[kind] += value, counts[kind] += 1.0F;
    }
    if (counts[0] > 0.0F) low = sums[0] / counts[0];
    if (counts[1] > 0.0F) high = sums[1] / counts[1];
  }
  Kinds kinds;
  kinds.two = high - low > kTwoKinds;
  for (int c = 0; c < 3; ++c) {
    std::array<std::vector<float>, 2> values;
    for (std::size_t t = 0; t < light.size(); ++t)
      values[!kinds.two || seen[t] <= 0.5F * (low + high) ? 0 : 1].push_back(std::log(light[t][c]));
    kinds.dark[c] = median_in_place(values[0]);
    kinds.bright[c] = kinds.two ? median_in_place(values[1]) : kinds.dark[c];
  }
  return kinds;
}

float unlikeness(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 off = glm::abs(a - b);
  return std::max({off.r, off.g, off.b});
}

// What is behind, followed from the rim of what sways inwards.
class Behind {
 public:
  // `kinds`: of the swaying pixels; of those around them `dark` is their median.
  Behind(const Image<Kinds>& kinds, const cv::Mat1b& swaying) : kinds_(kinds), light_(kinds.width(), kinds.height()) {
    known_ = swaying == 0;
    for (int y = 0; y < kinds.height(); ++y)
      for (int x = 0; x < kinds.width(); ++x) {
        if (known_(y, x) == 0) continue;
        light_.at(x, y) = kinds.at(x, y).dark;
        wake_neighbours(x, y);
      }
    follow();
    // Gaps that no way through free pixels leads to: as what is behind the nearest pixel.
    cv::Mat1b unknown;
    cv::bitwise_not(known_, unknown);
    if (cv::countNonZero(known_) == 0) return;
    cv::Mat distances, labels;
    cv::distanceTransform(unknown, distances, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    std::vector<glm::ivec2> place(static_cast<std::size_t>(cv::countNonZero(known_)) + 1);
    for (int y = 0; y < kinds.height(); ++y)
      for (int x = 0; x < kinds.width(); ++x)
        if (known_(y, x) != 0) place[static_cast<std::size_t>(labels.at<int>(y, x))] = {x, y};
    std::vector<std::pair<glm::ivec2, glm::vec3>> gaps;
    for (int y = 0; y < kinds.height(); ++y)
      for (int x = 0; x < kinds.width(); ++x) {
        if (known_(y, x) != 0) continue;
        const auto& nearest = place[static_cast<std::size_t>(labels.at<int>(y, x))];
        if (const auto found = like(light_.at(nearest.x, nearest.y), x, y)) gaps.emplace_back(glm::ivec2{x, y}, *found);
      }
    for (const auto& [at, found] : gaps) set(at.x, at.y, found);
    follow();
  }
  bool known(int x, int y) const { return known_(y, x) != 0; }
  const glm::vec3& at(int x, int y) const { return light_.at(x, y); }

 private:
  std::optional<glm::vec3> like(const glm::vec3& behind, int x, int y) const {
    const Kinds& kinds = kinds_.at(x, y);
    const float dark = unlikeness(kinds.dark, behind), bright = unlikeness(kinds.bright, behind);
    if (std::min(dark, bright) > kAlike) return std::nullopt;
    return dark < bright ? kinds.dark : kinds.bright;
  }
  void set(int x, int y, const glm::vec3& light) {
    if (known_(y, x) != 0) return;
    known_(y, x) = 255;
    light_.at(x, y) = light;
    wake_neighbours(x, y);
  }
  void wake_neighbours(int x, int y) {
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u)
        if (light_.contains(u, v) && known_(v, u) == 0) waiting_.push_back({u, v});
  }
  void follow() {
    for (; !waiting_.empty(); waiting_.pop_front()) {
      const auto [x, y] = std::pair{waiting_.front().x, waiting_.front().y};
      if (known_(y, x) != 0) continue;
      glm::vec3 sum(0.0F);
      float count = 0.0F;
      for (int v = y - 2; v <= y + 2; ++v)
        for (int u = x - 2; u <= x + 2; ++u)
          if (light_.contains(u, v) && known_(v, u) != 0) sum += light_.at(u, v), count += 1.0F;
      if (const auto found = like(sum / count, x, y)) set(x, y, *found);
    }
  }

  const Image<Kinds>& kinds_;
  Image<glm::vec3> light_;
  cv::Mat1b known_;
  std::deque<glm::ivec2> waiting_;
};

// Mean share of the pixel that is covered; less than .06 or more than .94 of it is noise or leaves of another brightness.
double covered_share(const std::vector<glm::vec3>& light, const glm::vec3& behind, const glm::vec3& front) {
  const glm::vec3 towards = front - behind;
  const float size2 = glm::dot(kSeen * towards, towards);
  double sum = 0.0;
  for (const auto& value : light) {
    const double share = static_cast<double>(glm::dot(kSeen * towards, value - behind) / size2);
    sum += share < 0.06 ? 0.0 : share > 0.94 ? 1.0 : share;
  }
  return sum / static_cast<double>(light.size());
}

// A pixel's share looked at again, where not all around it is free or covered: between what is purely behind and purely
// in front near by, since the pixel itself may never be either. `first`: the shares as found at first, 0..1.
double refined_share(const Series& series, const Image<Kinds>& kinds, const Behind& behind, const cv::Mat1d& first,
                     int x, int y) {
  glm::vec3 back(0.0F), front(0.0F);
  float backs = 0.0F, fronts = 0.0F;
  double low = 1.0, high = 0.0;
  for (int v = std::max(0, y - kNear_px); v <= std::min(first.rows - 1, y + kNear_px); ++v)
    for (int u = std::max(0, x - kNear_px); u <= std::min(first.cols - 1, x + kNear_px); ++u) {
      const double share = first(v, u);
      if (std::max(std::abs(u - x), std::abs(v - y)) <= 1) low = std::min(low, share), high = std::max(high, share);
      const Kinds& both = kinds.at(u, v);
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
  const Series series(pictures, response);
  const cv::Mat1b sways = swaying(series, within);
  if (cv::countNonZero(sways) == 0) return found;

  cv::Mat1b rim;
  cv::dilate(sways, rim, disc(kRim_px));
  Image<Kinds> kinds(width, height);
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
      const Kinds& both = kinds.at(x, y);
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
