#include "calib/mask/dome_spots.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr double kSurroundings = 1.0 / 16.0;  // standard deviation of the surroundings, of the picture's width
constexpr float kMinDimming = 0.08f;          // in ln light
constexpr float kMaxRoughness = 0.12f;        // in ln light: more is clouds, which say nothing
constexpr double kMinFrameShare = 0.8;        // of the frames
constexpr std::size_t kMinFrames = 8;
constexpr int kMinArea = 4;  // elements

struct Relief {
  cv::Mat light, colour;  // ln of green, ln of red over blue, relative to the surroundings
  cv::Mat roughness;      // root mean square of the first over the surroundings
};

Relief relief_of(const DomeFrame& frame, const Image<std::uint8_t>& usable) {
  const int width = frame.width(), height = frame.height();
  cv::Mat weight(height, width, CV_32F), light(height, width, CV_32F), colour(height, width, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto c = frame.at(x, y) + 1e-4f;
      weight.at<float>(y, x) = usable.at(x, y) ? 1.0f : 0.0f;
      light.at<float>(y, x) = std::log(c.y);
      colour.at<float>(y, x) = std::log(c.x / c.z);
    }
  const double sigma = kSurroundings * width;
  cv::Mat total;
  cv::GaussianBlur(weight, total, {}, sigma);
  const auto relative = [&](const cv::Mat& values) {
    cv::Mat mean, soft;
    cv::GaussianBlur(values.mul(weight), mean, {}, sigma);
    cv::GaussianBlur(values, soft, {}, 0.8);  // noise of the single element
    return cv::Mat(soft - mean / (total + 1e-6f));
  };
  Relief relief{relative(light), relative(colour), {}};
  cv::GaussianBlur(relief.light.mul(relief.light).mul(weight), relief.roughness, {}, sigma);
  cv::sqrt(relief.roughness / (total + 1e-6f), relief.roughness);
  return relief;
}

}  // namespace

DomeShade shade_of(const DomeFrame& frame, const Image<std::uint8_t>& usable) {
  const auto relief = relief_of(frame, usable);
  DomeShade shade{Image<std::uint8_t>(frame.width(), frame.height())};
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      if (!usable.at(x, y) || relief.roughness.at<float>(y, x) > kMaxRoughness) continue;
      const double dimming = 1.0 - std::exp(double{relief.light.at<float>(y, x)});
      const long steps = std::lround(std::clamp(dimming / DomeShade::kStep, 0.0, double{DomeShade::kSteepest}));
      shade.steps.at(x, y) = static_cast<std::uint8_t>(steps);
    }
  return shade;
}

DomeState find_spots(std::span<const DomeFrame> frames, const DomeShade& reference, const Image<std::uint8_t>& usable) {
  DomeState state;
  if (frames.size() < kMinFrames) return state;
  const int width = usable.width(), height = usable.height();
  if (reference.steps.width() != width || reference.steps.height() != height) return state;
  std::vector<Relief> reliefs;
  for (const auto& frame : frames) {
    if (frame.width() != width || frame.height() != height) return state;
    reliefs.push_back(relief_of(frame, usable));
  }
  cv::Mat often(height, width, CV_32F, cv::Scalar(0)), hue(height, width, CV_32F, cv::Scalar(0));
  Image<std::uint8_t> is_judged(width, height, 0);
  std::vector<float> all, values, hues;
  const auto fewest = std::max<std::size_t>(4, reliefs.size() / 4);
  int judged = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!usable.at(x, y)) continue;
      values.clear();
      hues.clear();
      for (const auto& relief : reliefs) {
        if (relief.roughness.at<float>(y, x) > kMaxRoughness) continue;
        values.push_back(relief.light.at<float>(y, x));
        hues.push_back(relief.colour.at<float>(y, x));
      }
      if (values.size() < fewest) continue;
      ++judged;
      is_judged.at(x, y) = 255;
      often.at<float>(y, x) = quantile_in_place(values, kMinFrameShare);
      hue.at<float>(y, x) = quantile_in_place(hues, 0.5);
      all.push_back(often.at<float>(y, x));
    }
  if (judged < 200) return state;
  state.looked_at = double(judged) / (double(width) * height);
  const float middle = quantile_in_place(all, 0.5);
  for (auto& value : all) value = std::abs(value - middle);
  const float least =
      std::max(kMinDimming, 5.0f * static_cast<float>(kSigmaOverMedianSize) * quantile_in_place(all, 0.5));
  state.least_dimming = 1.0 - std::exp(double{-least});

  cv::Mat dark(height, width, CV_8U, cv::Scalar(0)), labels, stats, centres;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float depth = often.at<float>(y, x);
      const bool bluer = hue.at<float>(y, x) < -least;
      const int steps = reference.steps.at(x, y);
      const bool was_so = steps > 0 && depth > static_cast<float>(std::log(1.0 - DomeShade::kStep * steps)) - least;
      if (is_judged.at(x, y) && depth < -least && !bluer && !was_so) dark.at<std::uint8_t>(y, x) = 255;
    }
  const int count = cv::connectedComponentsWithStats(dark, labels, stats, centres);
  for (int i = 1; i < count; ++i) {
    const int area = stats.at<int>(i, cv::CC_STAT_AREA);
    if (area < kMinArea) continue;
    double darkest = 0.0;
    cv::minMaxLoc(often, &darkest, nullptr, nullptr, nullptr, labels == i);
    state.spots.push_back(
        {{centres.at<double>(i, 0), centres.at<double>(i, 1)}, double(area) / judged, 1.0 - std::exp(darkest)});
  }
  std::sort(state.spots.begin(), state.spots.end(),
            [](const DomeSpot& a, const DomeSpot& b) { return a.dimming > b.dimming; });
  return state;
}

}  // namespace kasumi
