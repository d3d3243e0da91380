#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/picture_files/upright_picture.hpp"
#include "base/picture_header.hpp"
#include "base/table/config_table.hpp"
#include "calib/mask/scene_mask.hpp"

namespace kasumi {
namespace {

constexpr int kVivid = 96;  // of 255, how much a stroke's channel stands above the others: pens have soft edges

Result<Image<Stroke>> read_picture(const std::filesystem::path& path, int width, int height) {
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  const auto header = picture_header(*bytes);
  if (header && !header->is(width, height) && !header->is(height, width))
    return fail(FaultKind::bad_input, "{}: {} x {}, expected {} x {} like the picture the strokes are for",
                path.string(), header->width, header->height, width, height);
  const auto read = header ? decode_upright_picture(*header, *bytes) : Result<UprightPicture>();
  if (!read && read.error().kind == FaultKind::unsupported)
    return fail(read.error().kind, "{}: {}", path.string(), read.error().message);
  const cv::Mat rgba = read ? read->picture : cv::Mat();
  if (rgba.empty() || rgba.depth() != CV_8U || rgba.channels() < 3 || rgba.cols != width || rgba.rows != height)
    return fail(FaultKind::bad_input, "{}: expected a PNG of 8-bit colours with red, green or blue strokes",
                path.string());
  Image<Stroke> strokes(width, height, Stroke::none);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto* pixel = rgba.ptr<std::uint8_t>(y) + x * rgba.channels();
      if (rgba.channels() == 4 && pixel[3] < 128) continue;
      const int red = pixel[0], green = pixel[1], blue = pixel[2];
      if (red - std::max(green, blue) > kVivid)
        strokes.at(x, y) = Stroke::hidden;
      else if (std::max(green, blue) - red > kVivid)
        strokes.at(x, y) = Stroke::free;
    }
  return strokes;
}

void draw(const ConfigTable& table, Stroke kind, Image<Stroke>& strokes) {
  const auto points = table.numbers("points", 0, {-0.5, 16384.0});
  const double width_px = table.number("width_px", {1.0, 500.0}, 5.0);
  if (points.size() % 2 != 0 || points.size() < 2) {
    table.problem("points", "x1, y1, x2, y2, ... of one point or more");
    return;
  }
  for (std::size_t i = 0; i < points.size(); i += 2)
    if (points[i] > strokes.width() - 0.5 || points[i + 1] > strokes.height() - 0.5) {
      table.problem("points", fmt::format("points in a picture of {} x {}", strokes.width(), strokes.height()));
      return;
    }
  cv::Mat drawn(strokes.height(), strokes.width(), CV_8UC1, cv::Scalar(0));
  const auto at = [&](std::size_t i) {
    return cv::Point{static_cast<int>(std::lround(points[i])), static_cast<int>(std::lround(points[i + 1]))};
  };
  const int thick = std::max(1, static_cast<int>(std::lround(width_px)));
  for (std::size_t i = 0; i < points.size(); i += 2)
    cv::line(drawn, at(i >= 2 ? i - 2 : i), at(i), cv::Scalar(255), thick);
  for (int y = 0; y < strokes.height(); ++y)
    for (int x = 0; x < strokes.width(); ++x)
      if (drawn.at<std::uint8_t>(y, x) != 0) strokes.at(x, y) = kind;
}

}  // namespace

Result<Image<Stroke>> read_strokes(const std::filesystem::path& path, int width, int height) {
  if (path.extension() != ".toml") return read_picture(path, width, height);
  const auto root = ConfigTable::read_file(path);
  if (!root) return fail(root.error());
  Image<Stroke> strokes(width, height, Stroke::none);
  for (const auto& table : root->tables("hidden")) draw(table, Stroke::hidden, strokes);
  for (const auto& table : root->tables("free")) draw(table, Stroke::free, strokes);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return strokes;
}

}  // namespace kasumi
