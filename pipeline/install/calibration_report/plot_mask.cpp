#include "pipeline/install/calibration_report/plots.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/plot_style.hpp"

namespace kasumi {

namespace {

constexpr int kMaxMaskWidth = 1280, kMaskTitleHeight = 40;

}  // namespace

Image<Rgb8> plot_mask(const Image<Rgb8>& picture, const Image<std::uint8_t>& mask, const Image<Stroke>& strokes,
                      const std::string& title) {
  Image<Rgb8> drawn = picture;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const float hidden = 1.0F - static_cast<float>(mask.at(x, y)) / 255.0F;
      glm::vec3 colour = glm::mix(glm::vec3(picture.at(x, y)), glm::vec3(220.0F, 40.0F, 40.0F), 0.5F * hidden);
      const bool inside = mask.at(x, y) < 128;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}})
        if (mask.contains(x + dx, y + dy) && (mask.at(x + dx, y + dy) < 128) != inside)
          colour = {255.0F, 225.0F, 60.0F};
      if (!strokes.empty() && strokes.at(x, y) == Stroke::hidden) colour = {255.0F, 0.0F, 0.0F};
      if (!strokes.empty() && strokes.at(x, y) == Stroke::free) colour = {0.0F, 200.0F, 80.0F};
      drawn.at(x, y) = Rgb8(glm::round(colour));
    }
  const double scale = std::min(1.0, static_cast<double>(kMaxMaskWidth) / picture.width());
  const int wide = static_cast<int>(std::lround(scale * picture.width()));
  const int tall = static_cast<int>(std::lround(scale * picture.height()));
  Image<Rgb8> image(std::max(wide, 480), tall + kMaskTitleHeight, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat view = all(cv::Rect(0, kMaskTitleHeight, wide, tall));
  const cv::Mat from(picture.height(), picture.width(), CV_8UC3, drawn.elements().data());
  cv::resize(from, view, view.size(), 0, 0, scale < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
  cv::putText(all, title, {10, 25}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kInk, 1, cv::LINE_AA);
  return image;
}

}  // namespace kasumi
