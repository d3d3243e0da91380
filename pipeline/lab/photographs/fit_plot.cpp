#include "pipeline/lab/photographs/fit_plot.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/hosek.hpp"
#include "estimator/turbidity/fitted_sky.hpp"
#include "pipeline/lab/photographs/sky_model_choice.hpp"

namespace kasumi {

namespace {

constexpr int kSide = 520, kMargin = 70, kTop = 60;
const cv::Scalar kInk(40, 40, 40), kFaint(215, 215, 215), kAgrees(40, 150, 60), kDisagrees(220, 50, 40);

void write(cv::Mat& canvas, const std::string& text, cv::Point at, double size = 0.45) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
}

void draw_sky(cv::Mat canvas, const SkyPicture& picture, const TurbidityObservation& observation) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  const double scale = static_cast<double>(kSide) / std::max(width, height);
  for (int y = 0; y < canvas.rows; ++y)
    for (int x = 0; x < canvas.cols; ++x) {
      const int px = static_cast<int>(x / scale), py = static_cast<int>(y / scale);
      if (px >= width || py >= height) continue;
      glm::vec3 v = 255.0f * glm::clamp(picture.encoded.at(px, py), 0.0f, 1.0f);
      if (!observation.use.empty() && observation.use.at(px, py) == PixelUse::cloud)
        v = 0.6f * v + 0.4f * glm::vec3(60, 90, 255);
      canvas.at<cv::Vec3b>(y, x) = {cv::saturate_cast<uchar>(v.r), cv::saturate_cast<uchar>(v.g),
                                    cv::saturate_cast<uchar>(v.b)};
    }
  for (std::size_t i = 0; i < observation.elements.size(); ++i) {
    const cv::Point at(static_cast<int>((observation.elements[i].x + 0.5) * scale),
                       static_cast<int>((observation.elements[i].y + 0.5) * scale));
    const bool agrees = i < observation.inlier.size() && observation.inlier[i];
    cv::circle(canvas, at, 3, agrees ? kAgrees : kDisagrees, 1, cv::LINE_AA);
  }
}

struct Axis {
  double lowest = 0.0, highest = 1.0;
  double place(double value) const { return (value - lowest) / (highest - lowest); }
};

// ln of the followed model's luminance, in a unit of its own, by the cosine of the zenith angle and the sun's distance.
std::function<double(double, double)> followed_sky(const TurbidityObservation& observation) {
  const Turbidity turbidity = observation.estimate.turbidity;
  const SunDirection& sun = observation.estimate.sun;
  if (followed_model(observation.sky) == "hosek") {
    const auto sky = observation.sky.hosek->sky(turbidity, kHosekGroundAlbedo, sun);
    return [sky](double cos_zenith, double sun_distance) {
      const auto light = sky.linear_srgb(cos_zenith, std::cos(sun_distance));
      return std::log(std::max(1e-12, (srgb_to_xyz() * light).y));
    };
  }
  return [turbidity, sky = FittedSky(observation.sky, sun)](double cos_zenith, double sun_distance) {
    return sky.log_luminance(turbidity, cos_zenith, sun_distance);
  };
}

// ln of luminance over the zenith's: modelled and measured.
std::vector<cv::Point2d> points_of(const TurbidityObservation& observation) {
  std::vector<cv::Point2d> points;
  const auto sky = followed_sky(observation);
  const double zenith = sky(1.0, zenith_angle(observation.estimate.sun).value);
  std::vector<double> gains;
  for (std::size_t i = 0; i < observation.samples.size(); ++i) {
    const auto& sample = observation.samples[i];
    const double model = sky(std::cos(double{sample.zenith}), double{sample.sun_distance});
    points.emplace_back(model - zenith, double{sample.log_luminance} - zenith);
    if (i < observation.inlier.size() && observation.inlier[i]) gains.push_back(points.back().y - points.back().x);
  }
  const double gain = gains.empty() ? observation.log_gain : median_in_place(gains);
  for (auto& point : points) point.y -= gain;
  return points;
}

void draw_fit(cv::Mat canvas, const TurbidityObservation& observation) {
  const auto points = points_of(observation);
  if (points.empty()) {
    write(canvas, "no samples", {kSide / 2 - 40, kSide / 2});
    return;
  }
  Axis axis{points.front().x, points.front().x};
  for (const auto& point : points) {
    axis.lowest = std::min({axis.lowest, point.x, std::max(point.y, point.x - 1.0)});
    axis.highest = std::max({axis.highest, point.x, std::min(point.y, point.x + 1.0)});
  }
  axis.lowest -= 0.05;
  axis.highest += 0.05;
  const auto at = [&](double x, double y) {
    return cv::Point(static_cast<int>(kSide * axis.place(x)), static_cast<int>(kSide * (1.0 - axis.place(y))));
  };
  for (const double value : {0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0}) {
    const double v = std::log(value);
    if (v < axis.lowest || v > axis.highest) continue;
    cv::line(canvas, at(v, axis.lowest), at(v, axis.highest), kFaint);
    cv::line(canvas, at(axis.lowest, v), at(axis.highest, v), kFaint);
    write(canvas, fmt::format("{:g}", value), at(v, axis.lowest) + cv::Point(3, -5), 0.4);
    write(canvas, fmt::format("{:g}", value), at(axis.lowest, v) + cv::Point(4, -3), 0.4);
  }
  cv::line(canvas, at(axis.lowest, axis.lowest), at(axis.highest, axis.highest), kInk, 1, cv::LINE_AA);
  for (std::size_t i = 0; i < points.size(); ++i)
    cv::circle(canvas, at(points[i].x, points[i].y), 2,
               i < observation.inlier.size() && observation.inlier[i] ? kAgrees : kDisagrees, -1, cv::LINE_AA);
  cv::rectangle(canvas, cv::Rect(0, 0, kSide, kSide), kInk);
}

}  // namespace

Image<Rgb8> plot_fit(const SkyPicture& picture, const TurbidityObservation& observation, const std::string& title) {
  Image<Rgb8> image(2 * kSide + 3 * kMargin, kSide + kTop + kMargin, Rgb8(255));
  cv::Mat canvas(image.height(), image.width(), CV_8UC3, image.elements().data());
  write(canvas, title, {kMargin, 35}, 0.55);
  draw_sky(canvas(cv::Rect(kMargin, kTop, kSide, kSide)), picture, observation);
  draw_fit(canvas(cv::Rect(2 * kMargin + kSide, kTop, kSide, kSide)), observation);
  write(canvas, "green: samples that agree   red: that do not   blue tint: cloud", {kMargin, kTop + kSide + 25});
  const auto& sky = observation.sky;
  const std::string model = fmt::format("{}{}{}", followed_model(sky), sky.aerosol ? ", " : "",
                                        sky.aerosol ? name_of(sky.aerosol->kind) : "");
  write(canvas, "luminance / zenith: measured (up) against " + model + " (right)",
        {2 * kMargin + kSide, kTop + kSide + 25});
  return image;
}

}  // namespace kasumi
