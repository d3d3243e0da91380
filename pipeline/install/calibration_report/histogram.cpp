#include "pipeline/install/calibration_report/histogram.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/plot_style.hpp"

namespace kasumi {

namespace {

constexpr int kHistogramMargin = 40, kBins = 28;
const cv::Scalar kBar(40, 150, 60);

}  // namespace

Image<Rgb8> plot_histogram(std::span<const double> sizes, int width, int height, const std::string& caption) {
  Image<Rgb8> image(width, height, Rgb8(255));
  cv::Mat all(height, width, CV_8UC3, image.elements().data());
  const int wide = width - 2 * kHistogramMargin, tall = height - kHistogramMargin;
  const auto write = [&](const std::string& text, cv::Point at, double size) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  };
  std::vector<double> sorted(sizes.begin(), sizes.end());
  std::sort(sorted.begin(), sorted.end());
  const auto most_of = static_cast<std::size_t>(0.98 * static_cast<double>(sorted.empty() ? 0 : sorted.size() - 1));
  const double most = sorted.empty() ? 1.0 : std::max(1e-6, 1.2 * sorted[most_of]);
  std::array<int, kBins> bins{};
  for (const double size : sorted)
    ++bins[static_cast<std::size_t>(std::clamp(static_cast<int>(size / most * kBins), 0, kBins - 1))];
  const int tallest = std::max(1, *std::max_element(bins.begin(), bins.end()));
  for (int i = 0; i < kBins; ++i) {
    const int bar = (tall - 30) * bins[static_cast<std::size_t>(i)] / tallest;
    cv::rectangle(all, cv::Rect(kHistogramMargin + i * wide / kBins + 1, tall - bar, wide / kBins - 2, bar), kBar, -1);
  }
  cv::rectangle(all, cv::Rect(kHistogramMargin, 0, wide, tall), kInk);
  for (int i = 0; i <= 4; ++i)
    write(fmt::format("{:.{}f}", most * i / 4.0, most < 0.2 ? 3 : 2), {kHistogramMargin + i * wide / 4 - 14, tall + 17},
          0.4);
  write(fmt::format("{}", tallest), {4, 34}, 0.4);  // how many stand in the tallest bar
  write(caption, {kHistogramMargin, tall + 36}, 0.45);
  return image;
}

}  // namespace kasumi
