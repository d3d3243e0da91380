#include "pipeline/install/calibrate/board_window.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "gles/picture/flat_picture.hpp"

namespace kasumi {

namespace {

constexpr int kWide = 960, kBar = 34;

}  // namespace

Image<Rgb8> draw_coverage(const Image<std::uint8_t>& grey, const BoardCollector& collector,
                          const std::string& message) {
  const double scale = static_cast<double>(kWide) / grey.width();
  const int tall = static_cast<int>(std::lround(scale * grey.height()));
  Image<Rgb8> image(kWide, kBar + tall, Rgb8(20));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat view = all(cv::Rect(0, kBar, kWide, tall));
  auto copy = grey.elements();
  cv::Mat small;
  cv::resize(cv::Mat(grey.height(), grey.width(), CV_8UC1, copy.data()), small, view.size(), 0, 0,
             scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::cvtColor(small, view, cv::COLOR_GRAY2RGB);
  constexpr int kCells = BoardCollector::kCells;
  cv::Mat tint = view.clone();
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column) {
      const auto cell = collector.cell(column, row);
      if (cell == BoardCollector::Cell::dark) continue;
      const cv::Point from(kWide * column / kCells + 1, tall * row / kCells + 1),
          to(kWide * (column + 1) / kCells - 2, tall * (row + 1) / kCells - 2);
      const bool covered = cell == BoardCollector::Cell::covered;
      cv::rectangle(tint, from, to, covered ? cv::Scalar(60, 200, 90) : cv::Scalar(230, 80, 60), covered ? -1 : 3);
    }
  cv::addWeighted(tint, 0.3, view, 0.7, 0.0, view);
  if (collector.seen())
    for (const auto& pixel : collector.seen()->pixels)
      cv::circle(view,
                 {static_cast<int>(std::lround((pixel.x + 0.5) * scale)),
                  static_cast<int>(std::lround((pixel.y + 0.5) * scale))},
                 4, cv::Scalar(255, 220, 0), 1, cv::LINE_AA);
  cv::putText(all, message, {10, 23}, cv::FONT_HERSHEY_SIMPLEX, 0.6, cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
  return image;
}

Result<BoardWindow> BoardWindow::open() {
  auto window = open_window({"Kasumi: the lens", kWide, kWide * 3 / 4, false});
  if (!window) return fail(window.error());
  return BoardWindow(std::move(*window));
}

Result<bool> BoardWindow::show(const Image<std::uint8_t>& grey, const BoardCollector& collector,
                               const std::string& message) {
  if (!window_->handle_events()) return false;
  const auto drawn = draw_coverage(grey, collector, message);
  Image<Rgba8> picture(drawn.width(), drawn.height());
  for (std::size_t i = 0; i < drawn.elements().size(); ++i) picture.elements()[i] = Rgba8(drawn.elements()[i], 255);
  const auto flat = FlatPicture::create(*window_, picture);
  if (!flat) return fail(flat.error());
  const auto target = window_->target();
  clear_to(target, glm::vec3(0.08f));
  if (auto done = flat->draw(target, fitted(target, picture.width(), picture.height())); !done)
    return fail(done.error());
  window_->show();
  return true;
}

}  // namespace kasumi
