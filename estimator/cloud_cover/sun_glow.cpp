#include "estimator/cloud_cover/sun_glow.hpp"

#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace kasumi {

namespace {

// Relative scatter of light and scatter of blueness over some 6 deg; clear sky has 0.002 to 0.006, cloud 0.01 to 0.1.
constexpr float kSmoothLight = 0.007f, kSmoothBlue = 0.010f;
constexpr double kPatch = 0.12;  // thickness of a patch that may be the sun
constexpr float kDisc = 14.0f;   // degrees: the disc and its bloom have edges of their own; glow begins within
constexpr float kReach = 75.0f;  // degrees from the sun that glow reaches at most
constexpr float kLow = 78.0f;    // degrees from the zenith: whiteness of the horizon

cv::Mat1b smooth_parts(const PixelFeatures& sky, const cv::Mat1b& region) {
  const int wide = scaled_side(sky, 13), patch = scaled_side(sky, 9);
  const InsideMeans over_wide(region, wide), over_patch(region, patch);
  const cv::Mat1f fine = InsideMeans(region, 3).of(sky.light);
  const cv::Mat1f light = over_wide.of(sky.light), blue = over_wide.of(sky.blueness);
  const cv::Mat1f light_off(cv::abs(fine - light)), blue_off(cv::abs(sky.blueness - blue));
  const cv::Mat1f rough_light(over_patch.of(light_off) / (light + 0.02));
  const cv::Mat1f rough_blue = over_patch.of(blue_off);
  return cv::Mat1b((rough_light < kSmoothLight) & (rough_blue < kSmoothBlue) & region);
}

}  // namespace

std::optional<SunDirection> brightest_patch(const PixelFeatures& sky, const cv::Mat1b& region) {
  cv::Mat1f clipped, thickness;
  cv::Mat1b(sky.clipped & region).convertTo(clipped, CV_32F, 1.0 / 255.0);
  const int side = scaled_side(sky, 15);
  cv::blur(clipped, thickness, {side, side}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(thickness, thickness, {side, side}, {-1, -1}, cv::BORDER_CONSTANT);
  double most = 0.0;
  cv::Point at;
  cv::minMaxLoc(thickness, nullptr, &most, nullptr, &at, region);
  if (most < kPatch) return std::nullopt;
  const cv::Vec3f& d = sky.direction(at);
  return SunDirection{d[0], d[1], d[2]};
}

cv::Mat1b glow(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1b& white, const cv::Mat1f& sun_deg) {
  const cv::Mat1b smooth = smooth_parts(sky, region);
  cv::Mat1b found(white & smooth & (sky.zenith_deg > kLow));
  if (sun_deg.empty()) return cv::Mat1b(found & ~sky.clipped);
  const cv::Mat1b disc(sun_deg < kDisc * 0.5f);
  const cv::Mat1b candidates(((white & smooth) | (sky.clipped & region) | (disc & region)) & (sun_deg < kReach));
  cv::Mat1i label;
  const int areas = cv::connectedComponents(candidates, label, 4, CV_32S);
  std::vector<char> starts(static_cast<std::size_t>(areas), 0);
  for (int y = 0; y < label.rows; ++y)
    for (int x = 0; x < label.cols; ++x)
      if (label(y, x) > 0 && sun_deg(y, x) < kDisc) starts[static_cast<std::size_t>(label(y, x))] = 1;
  for (int y = 0; y < label.rows; ++y)
    for (int x = 0; x < label.cols; ++x)
      if (label(y, x) > 0 && starts[static_cast<std::size_t>(label(y, x))]) found(y, x) = 255;
  return cv::Mat1b(found & ~sky.clipped);
}

}  // namespace kasumi
