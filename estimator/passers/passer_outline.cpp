#include "estimator/passers/passer_outline.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr int kAround_px = 8;                       // of the covered cells, in which the outline may lie
constexpr float kDiffers = 4.2F;                    // of the mean luma of 3 x 3 pixels, steps of 255; or
constexpr float kNoises = 4.0F;                     // so many of its standard deviations, if that is more
constexpr float kTextures = 2.6F;                   // or each differs by as many of a pixel's: the texture is another
constexpr float kColourDiffers = 1.8F;              // as much more of colour, which cameras spread over its neighbours
constexpr int kClose_px = 3;                        // gaps up to twice as wide belong to the passer
constexpr int kFront_px = 2;                        // around an edge's pixel, where the passer's own light is taken
constexpr float kLeastContrast = 12.0F;             // of passer and background, below which edges are not solved
constexpr float kMore = 1.1F, kMoreOffset = 0.06F;  // prefer a halo to a clipped person

using Mask = Image<std::uint8_t>;

cv::Mat mat_of(Mask& mask) {
  return {mask.height(), mask.width(), CV_8U, mask.elements().data()};
}

cv::Mat square(int reach) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1});
}

// What cannot be reached from the border without crossing the mask belongs to it.
void fill(cv::Mat& mask) {
  cv::Mat padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::floodFill(padded, {0, 0}, 2);
  cv::Mat(padded(cv::Rect(1, 1, mask.cols, mask.rows)) != 2).copyTo(mask);
}

// Leaves the islands that a covered cell touches.
void keep_touching(cv::Mat& mask, const Mask& touched) {
  cv::Mat islands;
  std::vector<std::uint8_t> kept(static_cast<std::size_t>(cv::connectedComponents(mask, islands)), 0);
  const auto island = [&](int x, int y) { return static_cast<std::size_t>(islands.at<int>(y, x)); };
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (touched.at(x, y)) kept[island(x, y)] = 1;
  kept[0] = 0;  // what is no island
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) mask.at<std::uint8_t>(y, x) = kept[island(x, y)];
}

glm::u8vec3 encoded(const glm::vec3& yuv, const YuvToRgb& conversion) {
  const glm::vec3 from = yuv / 255.0F - conversion.offset;
  glm::u8vec3 rgb{0};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[static_cast<glm::length_t>(c)] =
        static_cast<std::uint8_t>(std::clamp(std::lround(255.0F * glm::dot(conversion.rows[c], from)), 0L, 255L));
  return rgb;
}

}  // namespace

PassersInFront outline_of(const PicturePart& picture, const ExpectedScene& expected,
                          const Image<std::uint8_t>& covered) {
  // The box of the covered cells with what may belong to them.
  int x0 = covered.width(), y0 = covered.height(), x1 = 0, y1 = 0;
  for (int y = 0; y < covered.height(); ++y)
    for (int x = 0; x < covered.width(); ++x)
      if (covered.at(x, y))
        x0 = std::min(x0, x), x1 = std::max(x1, x + 1), y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
  if (x0 >= x1) return {};
  const PartPlace& place = picture.place();
  const int side = place.cell_px;
  x0 = std::max(0, x0 * side - kAround_px - 2), y0 = std::max(0, y0 * side - kAround_px - 2);
  x1 = std::min(place.width, x1 * side + kAround_px + 2);
  y1 = std::min(place.height, y1 * side + kAround_px + 2);
  const int w = x1 - x0, h = y1 - y0;

  Mask within(w, h, 0), touched(w, h, 0);
  for (int row = 0; row < covered.height(); ++row)
    for (int column = 0; column < covered.width(); ++column) {
      if (!covered.at(column, row)) continue;
      const int left = column * side - x0, top = row * side - y0;
      for (int y = std::max(0, top - kAround_px); y < std::min(h, top + side + kAround_px); ++y)
        for (int x = std::max(0, left - kAround_px); x < std::min(w, left + side + kAround_px); ++x) {
          within.at(x, y) = 1;
          if (x >= left && x < left + side && y >= top && y < top + side) touched.at(x, y) = 1;
        }
    }
  Image<glm::vec3> behind(w, h, glm::vec3{0}), off(w, h, glm::vec3{0});
  const auto now_at = [&](int x, int y) {
    return glm::vec3{picture.luma().at(x0 + x, y0 + y), picture.blue().at((x0 + x) / 2, (y0 + y) / 2),
                     picture.red().at((x0 + x) / 2, (y0 + y) / 2)};
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (!within.at(x, y) || !expected.knows((x0 + x) / side, (y0 + y) / side)) continue;
      behind.at(x, y) = expected.pixel(x0 + x, y0 + y);
      off.at(x, y) = now_at(x, y) - behind.at(x, y);
    }
  const auto least = std::max(kDiffers, kNoises * static_cast<float>(expected.detail_noise()));
  const auto texture = std::max(kDiffers, kTextures * static_cast<float>(expected.pixel_noise()));
  Mask front(w, h, 0);
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      if (!within.at(x, y)) continue;
      glm::vec3 sum{0};
      float square = 0.0F;
      for (int d = 0; d < 9; ++d) {
        const glm::vec3& one = off.at(x + d % 3 - 1, y + d / 3 - 1);
        sum += one;
        square += one.x * one.x;
      }
      sum *= 1.0F / 9.0F;
      const float colour2 = (sum.y * sum.y + sum.z * sum.z) / (kColourDiffers * kColourDiffers);
      if (sum.x * sum.x + colour2 > least * least || square > 9.0F * texture * texture) front.at(x, y) = 1;
    }
  Mask inner(w, h), outer(w, h);
  cv::Mat front_mat = mat_of(front), inner_mat = mat_of(inner), outer_mat = mat_of(outer);
  cv::morphologyEx(front_mat, front_mat, cv::MORPH_CLOSE, square(kClose_px));
  fill(front_mat);
  keep_touching(front_mat, touched);
  cv::erode(front_mat, inner_mat, square(1));
  cv::dilate(front_mat, outer_mat, square(1));

  PassersInFront made;
  made.left = place.left + x0 - 1;
  made.top = place.top + y0 - 1;
  made.pixels = Image<glm::u8vec4>(w + 2, h + 2, glm::u8vec4{0, 0, 0, 255});
  const YuvToRgb conversion = yuv_to_rgb(picture.encoding());
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (!outer.at(x, y) || !expected.knows((x0 + x) / side, (y0 + y) / side)) continue;
      float share = front.at(x, y) ? 1.0F : 0.0F;
      if (!inner.at(x, y)) {
        glm::vec3 own{0};
        float count = 0.0F;
        for (int v = std::max(0, y - kFront_px); v <= std::min(h - 1, y + kFront_px); ++v)
          for (int u = std::max(0, x - kFront_px); u <= std::min(w - 1, x + kFront_px); ++u)
            if (inner.at(u, v)) own += now_at(u, v), count += 1.0F;
        if (count > 0.0F) {
          const glm::vec3 towards = own / count - behind.at(x, y);
          const float size2 = glm::dot(towards, towards);
          if (size2 > kLeastContrast * kLeastContrast)
            share = std::max(0.5F * share,
                             std::clamp(kMore * glm::dot(off.at(x, y), towards) / size2 + kMoreOffset, 0.0F, 1.0F));
        }
      }
      const auto free = static_cast<std::uint8_t>(std::lround(255.0F * (1.0F - share)));
      made.pixels.at(x + 1, y + 1) = {encoded(behind.at(x, y), conversion), free};
    }
  return made;
}

}  // namespace kasumi
