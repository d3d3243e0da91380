#include "pipeline/site/files/contact_sheet.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

constexpr int kGap_px = 6;
const cv::Scalar kGround(32, 32, 32), kInk(255, 255, 255);

cv::Mat matrix_of(const Image<Rgb8>& picture) {
  cv::Mat matrix(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& p = picture.at(x, y);
      matrix.at<cv::Vec3b>(y, x) = {p.r, p.g, p.b};
    }
  return matrix;
}

Image<Rgb8> image_of(const cv::Mat& matrix) {
  Image<Rgb8> picture(matrix.cols, matrix.rows);
  for (int y = 0; y < matrix.rows; ++y)
    for (int x = 0; x < matrix.cols; ++x) {
      const auto& p = matrix.at<cv::Vec3b>(y, x);
      picture.at(x, y) = {p[0], p[1], p[2]};
    }
  return picture;
}

}  // namespace

void ContactSheet::add(const Image<Rgb8>& picture, std::string caption) {
  cv::Mat matrix = matrix_of(picture);
  if (matrix.cols > widest_px_) {
    const int height = std::max(1, static_cast<int>(std::lround(1.0 * matrix.rows * widest_px_ / matrix.cols)));
    cv::resize(matrix, matrix, {widest_px_, height}, 0.0, 0.0, cv::INTER_AREA);
  }
  tiles_.push_back({image_of(matrix), std::move(caption)});
}

Image<Rgb8> ContactSheet::drawn(int columns) const {
  int width = 0, height = 0;
  for (const auto& tile : tiles_) {
    width = std::max(width, tile.picture.width());
    height = std::max(height, tile.picture.height());
  }
  const int count = static_cast<int>(tiles_.size());
  if (columns <= 0)
    columns = std::clamp(static_cast<int>(std::lround(std::sqrt(1.0 * count * height / width))), 1, count);
  const int rows = (count + columns - 1) / columns;
  cv::Mat sheet(rows * (height + kGap_px) + kGap_px, columns * (width + kGap_px) + kGap_px, CV_8UC3, kGround);
  for (int i = 0; i < count; ++i) {
    const auto& tile = tiles_[static_cast<std::size_t>(i)];
    const cv::Point at(kGap_px + i % columns * (width + kGap_px), kGap_px + i / columns * (height + kGap_px));
    auto place = sheet(cv::Rect(at.x, at.y, tile.picture.width(), tile.picture.height()));
    matrix_of(tile.picture).copyTo(place);
    const auto size = cv::getTextSize(tile.caption, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr);
    cv::rectangle(sheet, cv::Rect(at.x, at.y, size.width + 10, size.height + 10), kGround, cv::FILLED);
    cv::putText(sheet, tile.caption, at + cv::Point(5, size.height + 5), cv::FONT_HERSHEY_SIMPLEX, 0.5, kInk, 1,
                cv::LINE_AA);
  }
  return image_of(sheet);
}

Result<> ContactSheet::write(const std::filesystem::path& path) const {
  if (tiles_.empty()) return fail(FaultKind::bad_input, "{}: expected at least one picture", path.string());
  return write_png(path, drawn());
}

}  // namespace kasumi
