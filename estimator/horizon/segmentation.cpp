// Sky and ground of a scene picture, by OpenCV's watershed.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {
namespace {

constexpr int kWorkingWidth = 360;           // enough for a silhouette, and downscaling averages noise away
constexpr double kSmallestSkyShare = 0.015;  // of the picture
constexpr double kDarkestSky = 25.0;         // lightness 0..100
// Markers of OpenCV's watershed: any positive numbers.
constexpr int kSkyLabel = 1;
constexpr int kGroundLabel = 2;

struct Working {
  cv::Mat rgb;                     // 8UC3, small, denoised
  cv::Mat lightness;               // 32F, 0..100
  cv::Mat red_green, yellow_blue;  // 32F, CIE a and b
  cv::Mat texture;                 // 32F, deviation of lightness from its surroundings
  cv::Mat never_sky;               // 8U
};

// CIE L*, a*, b* of sRGB. OpenCV's own conversion makes 5 MB of tables first, which takes a tenth of a second.
std::array<cv::Mat, 3> lab_of(const cv::Mat& rgb) {
  static const auto light = [] {
    std::array<float, 256> of_code{};
    for (std::size_t code = 0; code < of_code.size(); ++code)
      of_code[code] = static_cast<float>(Response::srgb().to_light(glm::dvec3{static_cast<double>(code) / 255.0}).x);
    return of_code;
  }();
  const auto f = [](float t) { return t > 216.0F / 24389.0F ? std::cbrt(t) : (24389.0F / 27.0F * t + 16.0F) / 116.0F; };
  std::array<cv::Mat, 3> lab;
  for (cv::Mat& plane : lab) plane.create(rgb.size(), CV_32F);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const auto& codes = rgb.at<cv::Vec3b>(y, x);
      const float r = light[codes[0]], g = light[codes[1]], b = light[codes[2]];
      const float along_x = f((0.412453F * r + 0.357580F * g + 0.180423F * b) / 0.950456F);
      const float along_y = f(0.212671F * r + 0.715160F * g + 0.072169F * b);
      const float along_z = f((0.019334F * r + 0.119193F * g + 0.950227F * b) / 1.088754F);
      lab[0].at<float>(y, x) = 116.0F * along_y - 16.0F;
      lab[1].at<float>(y, x) = 500.0F * (along_x - along_y);
      lab[2].at<float>(y, x) = 200.0F * (along_y - along_z);
    }
  return lab;
}

Working prepare(const Image<Rgb8>& picture, const Image<std::uint8_t>& never_sky) {
  // OpenCV does not write through this header; the const_cast is needed because cv::Mat has no const form.
  const cv::Mat full(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.row(0)));
  const double scale = std::min(1.0, static_cast<double>(kWorkingWidth) / picture.width());
  const cv::Size size(std::max(8, static_cast<int>(std::lround(picture.width() * scale))),
                      std::max(8, static_cast<int>(std::lround(picture.height() * scale))));
  Working w;
  cv::resize(full, w.rgb, size, 0, 0, cv::INTER_AREA);
  cv::medianBlur(w.rgb, w.rgb, 5);
  const auto lab = lab_of(w.rgb);
  w.lightness = lab[0];
  w.red_green = lab[1];
  w.yellow_blue = lab[2];
  // Deviation from the surroundings, so that a sky's smooth gradient does not count as texture.
  cv::Mat surroundings, deviation;
  cv::GaussianBlur(w.lightness, surroundings, {}, 3.0);
  cv::absdiff(w.lightness, surroundings, deviation);
  cv::blur(deviation, w.texture, {7, 7});
  if (never_sky.empty()) {
    w.never_sky = cv::Mat::zeros(size, CV_8U);
  } else {
    const cv::Mat mask(never_sky.height(), never_sky.width(), CV_8U, const_cast<std::uint8_t*>(never_sky.row(0)));
    cv::resize(mask, w.never_sky, size, 0, 0, cv::INTER_NEAREST);
  }
  return w;
}

double quantile_of(const cv::Mat& picture, double share) {
  std::vector<float> values;
  values.reserve(picture.total());
  for (int y = 0; y < picture.rows; ++y)
    values.insert(values.end(), picture.ptr<float>(y), picture.ptr<float>(y) + picture.cols);
  return static_cast<double>(quantile_in_place(values, share));
}

cv::Mat kernel(int side) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
}

// Areas that are certainly sky: textureless, bright or blue, in the upper part; those that touch the top, or else the
// largest.
cv::Mat sky_seeds(const Working& w, double smooth) {
  const double bright = quantile_of(w.lightness, 0.98);
  cv::Mat seeds = cv::Mat::zeros(w.rgb.size(), CV_8U);
  for (int y = 0; y < w.rgb.rows * 3 / 5; ++y) {
    for (int x = 0; x < w.rgb.cols; ++x) {
      const auto lightness = static_cast<double>(w.lightness.at<float>(y, x));
      const auto a = static_cast<double>(w.red_green.at<float>(y, x));
      const auto b = static_cast<double>(w.yellow_blue.at<float>(y, x));
      const bool is_smooth = static_cast<double>(w.texture.at<float>(y, x)) < smooth;
      const bool blue = b < -8.0 && lightness > kDarkestSky;
      const bool pale = lightness > std::max(kDarkestSky, 0.7 * bright);
      const bool leafy = a < -8.0 && b > 8.0;
      const bool earthen = b > 25.0 && lightness < 60.0;
      if (is_smooth && (blue || pale) && !leafy && !earthen && w.never_sky.at<std::uint8_t>(y, x) == 0) {
        seeds.at<std::uint8_t>(y, x) = 255;
      }
    }
  }
  cv::erode(seeds, seeds, kernel(5), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(seeds, labels, stats, centroids, 4, CV_32S);
  const int smallest = static_cast<int>(0.003 * static_cast<double>(w.rgb.total()));
  std::vector<bool> keep(static_cast<std::size_t>(count), false);
  int largest = 0;
  bool any_at_top = false;
  for (int i = 1; i < count; ++i) {
    const int area = stats.at<int>(i, cv::CC_STAT_AREA);
    if (area < smallest) continue;
    if (largest == 0 || area > stats.at<int>(largest, cv::CC_STAT_AREA)) largest = i;
    if (stats.at<int>(i, cv::CC_STAT_TOP) <= w.rgb.rows / 12) {
      keep[static_cast<std::size_t>(i)] = true;
      any_at_top = true;
    }
  }
  if (!any_at_top && largest > 0) keep[static_cast<std::size_t>(largest)] = true;
  for (int y = 0; y < seeds.rows; ++y) {
    for (int x = 0; x < seeds.cols; ++x) {
      seeds.at<std::uint8_t>(y, x) = keep[static_cast<std::size_t>(labels.at<int>(y, x))] ? 255 : 0;
    }
  }
  return seeds;
}

// Areas that are certainly not sky: the bottom, what the mask excludes, and what is textured or much darker than the
// sky, after thin edges are removed.
cv::Mat ground_seeds(const Working& w, const cv::Mat& sky, double smooth) {
  const auto sky_lightness = cv::mean(w.lightness, sky)[0];
  cv::Mat textured = w.texture > 4.0 * smooth;
  cv::Mat darker = w.lightness < 0.85 * sky_lightness;
  cv::Mat much_darker = w.lightness < 0.5 * sky_lightness;
  cv::Mat ground = (textured & darker) | much_darker;
  cv::morphologyEx(ground, ground, cv::MORPH_OPEN, kernel(3));
  ground.rowRange(w.rgb.rows - std::max(2, w.rgb.rows / 25), w.rgb.rows).setTo(255);
  ground.setTo(255, w.never_sky);
  ground.setTo(0, sky);
  return ground;
}

// Stretches differences from the sky's colour, so that hills that fade into it still have an edge for the watershed.
cv::Mat stretched(const Working& w, const cv::Mat& sky) {
  constexpr double kStretch = 4.0;  // differences of 32 of 255 from the sky's colour then reach full scale
  const cv::Scalar mean = cv::mean(w.rgb, sky);
  cv::Mat smooth, result;
  cv::GaussianBlur(w.rgb, smooth, {}, 1.0);
  smooth.convertTo(result, CV_32F);
  result -= mean;
  result.convertTo(result, CV_8U, kStretch, 128.0);
  return result;
}

// Ground completely surrounded by sky (a bird, a cloud's dark underside) counts as sky.
void fill_holes(cv::Mat& sky, const cv::Mat& never_sky) {
  const cv::Mat ground = sky == 0;
  cv::Mat labels;
  const int count = cv::connectedComponents(ground, labels, 8, CV_32S);
  std::vector<bool> held(static_cast<std::size_t>(count), false);
  for (int y = 0; y < sky.rows; ++y) {
    for (int x = 0; x < sky.cols; ++x) {
      const bool at_rim = x == 0 || y == 0 || x == sky.cols - 1 || y == sky.rows - 1;
      if (at_rim || never_sky.at<std::uint8_t>(y, x) != 0) {
        held[static_cast<std::size_t>(labels.at<int>(y, x))] = true;
      }
    }
  }
  for (int y = 0; y < sky.rows; ++y) {
    for (int x = 0; x < sky.cols; ++x) {
      if (!held[static_cast<std::size_t>(labels.at<int>(y, x))]) sky.at<std::uint8_t>(y, x) = 255;
    }
  }
}

SkySegmentation none(const Image<Rgb8>& picture, std::string reason) {
  return {false, std::move(reason), Image<std::uint8_t>(picture.width(), picture.height()), 0.0};
}

SkySegmentation segment(const Image<Rgb8>& picture, const Image<std::uint8_t>& never_sky) {
  if (picture.width() < 16 || picture.height() < 16) return none(picture, "no sky: the picture is too small");
  if (!never_sky.empty() && (never_sky.width() != picture.width() || never_sky.height() != picture.height())) {
    return none(picture, "no sky: the mask of pixels that cannot be sky differs from the picture in size");
  }
  const Working w = prepare(picture, never_sky);
  if (quantile_of(w.lightness, 0.95) < kDarkestSky) return none(picture, "no sky: the picture is dark");

  // A noisy picture's sky is as textured as its noise: the smoothest fifth of the upper half is the measure.
  const double noise = quantile_of(w.texture.rowRange(0, w.rgb.rows / 2), 0.2);
  const double smooth = std::clamp(3.0 * noise, 0.6, 2.0);
  const cv::Mat seeds = sky_seeds(w, smooth);
  if (cv::countNonZero(seeds) == 0) return none(picture, "no sky: nothing bright and textureless in the upper part");

  cv::Mat markers = cv::Mat::zeros(w.rgb.size(), CV_32S);
  markers.setTo(kGroundLabel, ground_seeds(w, seeds, smooth));
  markers.setTo(kSkyLabel, seeds);
  cv::watershed(stretched(w, seeds), markers);
  cv::Mat sky = markers == kSkyLabel;
  // The watershed leaves its one-pixel lines and the picture's border undecided: the border copies its neighbour.
  sky.row(1).copyTo(sky.row(0));
  sky.col(1).copyTo(sky.col(0));
  sky.col(sky.cols - 2).copyTo(sky.col(sky.cols - 1));
  fill_holes(sky, w.never_sky);
  sky.setTo(0, w.never_sky);

  SkySegmentation result;
  result.sky_fraction = cv::countNonZero(sky) / static_cast<double>(sky.total());
  result.sky = Image<std::uint8_t>(picture.width(), picture.height());
  cv::Mat full(picture.height(), picture.width(), CV_8U, result.sky.row(0));
  cv::resize(sky, full, full.size(), 0, 0, cv::INTER_NEAREST);
  result.visible = result.sky_fraction >= kSmallestSkyShare;
  if (!result.visible) {
    result.reason = fmt::format("no sky: {:.1f} % of the picture is less than the {:.1f} % needed",
                                100.0 * result.sky_fraction, 100.0 * kSmallestSkyShare);
  }
  return result;
}

}  // namespace

SkySegmentation segment_sky(const Image<Rgb8>& picture, const Image<std::uint8_t>& never_sky) {
  try {
    return segment(picture, never_sky);
  } catch (const cv::Exception& error) {
    return none(picture, fmt::format("no sky: OpenCV says {}", error.what()));
  }
}

}  // namespace kasumi
