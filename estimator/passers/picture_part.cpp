#include "estimator/passers/picture_part.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace kasumi {
namespace {

std::uint8_t to_byte(int value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0, 255));
}

// Full-range BT.601 in 16 bits of fraction.
std::uint8_t luma_of(const Rgb8& c) {
  return to_byte((19595 * c.r + 38470 * c.g + 7471 * c.b + 32768) >> 16);
}

// The planes that a layout keeps as they are: every `step`-th byte of `count` in a row.
template <int step>
void pick_every(const std::uint8_t* __restrict from, int count, std::uint8_t* __restrict to) {
  for (int i = 0; i < count; ++i) to[i] = from[i * step];
}
void pick(const std::uint8_t* from, int step, int count, std::uint8_t* to) {
  if (step == 1) return pick_every<1>(from, count, to);
  if (step == 2) return pick_every<2>(from, count, to);
  pick_every<4>(from, count, to);
}

// The sums of `side` x `side` bytes each, of a row of such squares.
void sum_squares(const Image<std::uint8_t>& of, int row, int side, std::vector<int>& sums) {
  std::vector<std::uint32_t> columns(static_cast<std::size_t>(of.width()), 0);
  for (int y = row * side; y < (row + 1) * side; ++y) {
    const std::uint8_t* __restrict from = of.row(y);
    std::uint32_t* __restrict to = columns.data();
    for (int x = 0; x < of.width(); ++x) to[x] += from[x];
  }
  sums.resize(columns.size() / static_cast<std::size_t>(side));
  for (std::size_t i = 0; i < sums.size(); ++i)
    sums[i] = std::accumulate(columns.begin() + static_cast<std::ptrdiff_t>(i) * side,
                              columns.begin() + static_cast<std::ptrdiff_t>(i + 1) * side, 0,
                              [](int sum, std::uint32_t one) { return sum + static_cast<int>(one); });
}

struct Packing {
  int luma_step, luma_first;
  int blue_plane, red_plane;
  int chroma_step, blue_first, red_first;  // bytes for two pixels
  int chroma_rows;                         // pixels per row of chroma
};

// False: RGB, grey or 4:4:4.
bool packing_of(PixelLayout layout, Packing& packing) {
  switch (layout) {
    case PixelLayout::yuyv: packing = {2, 0, 0, 0, 4, 1, 3, 1}; return true;
    case PixelLayout::uyvy: packing = {2, 1, 0, 0, 4, 0, 2, 1}; return true;
    case PixelLayout::nv12: packing = {1, 0, 1, 1, 2, 0, 1, 2}; return true;
    case PixelLayout::i420: packing = {1, 0, 1, 2, 1, 0, 0, 2}; return true;
    case PixelLayout::i422: packing = {1, 0, 1, 2, 1, 0, 0, 1}; return true;
    default: return false;
  }
}

bool is_yuv(PixelLayout layout) {
  Packing unused{};
  return layout == PixelLayout::i444 || packing_of(layout, unused);
}

}  // namespace

PartPlace part_around(int left, int top, int right, int bottom, int margin_px, int width, int height) {
  constexpr int kMostCells = 6000;  // bounds the time per picture: cells grow from 4 to 8 or 16 pixels instead
  PartPlace place;
  const int first_column = std::max(0, left - margin_px) / 2 * 2, first_row = std::max(0, top - margin_px) / 2 * 2;
  const int right_end = std::min(right + margin_px, width), bottom_end = std::min(bottom + margin_px, height);
  for (place.cell_px = 4;; place.cell_px *= 2) {
    place.left = first_column;
    place.top = first_row;
    place.width = (right_end - place.left) / place.cell_px * place.cell_px;
    place.height = (bottom_end - place.top) / place.cell_px * place.cell_px;
    if (place.columns() * place.rows() <= kMostCells) return place;
  }
}

Image<glm::vec3> means_of_cells(const Image<std::uint8_t>& luma, const Image<std::uint8_t>& blue,
                                const Image<std::uint8_t>& red, int cell_px) {
  Image<glm::vec3> cells(luma.width() / cell_px, luma.height() / cell_px);
  std::vector<int> lumas, blues, reds;
  const int half = cell_px / 2;
  const auto mean = [](const std::vector<int>& sums, int column, int side) {
    return static_cast<float>(sums[static_cast<std::size_t>(column)]) / static_cast<float>(side * side);
  };
  for (int row = 0; row < cells.height(); ++row) {
    sum_squares(luma, row, cell_px, lumas);
    sum_squares(blue, row, half, blues);
    sum_squares(red, row, half, reds);
    for (int column = 0; column < cells.width(); ++column)
      cells.at(column, row) = {mean(lumas, column, cell_px), mean(blues, column, half) - 128.0F,
                               mean(reds, column, half) - 128.0F};
  }
  return cells;
}

void PicturePart::read(const PictureView& picture, const PartPlace& place) {
  place_ = place;
  encoding_ = is_yuv(picture.layout) ? picture.encoding : YuvEncoding::bt601_full;
  if (luma_.width() != place.width || luma_.height() != place.height) {
    luma_ = Image<std::uint8_t>(place.width, place.height);
    blue_ = red_ = Image<std::uint8_t>(place.width / 2, place.height / 2);
  }
  Packing packing{};
  if (packing_of(picture.layout, packing)) {
    for (int y = 0; y < place.height; ++y) {
      const auto* row = picture.planes[0].data + static_cast<std::size_t>(place.top + y) * picture.planes[0].stride;
      pick(row + place.left * packing.luma_step + packing.luma_first, packing.luma_step, place.width, luma_.row(y));
    }
    const int pairs = place.width / 2;
    for (int y = 0; y < place.height / 2; ++y) {
      const auto chroma_row = static_cast<std::size_t>((place.top + 2 * y) / packing.chroma_rows);
      const auto from = [&](int plane, int first) {
        const auto& of = picture.planes[static_cast<std::size_t>(plane)];
        return of.data + chroma_row * of.stride + place.left / 2 * packing.chroma_step + first;
      };
      pick(from(packing.blue_plane, packing.blue_first), packing.chroma_step, pairs, blue_.row(y));
      pick(from(packing.red_plane, packing.red_first), packing.chroma_step, pairs, red_.row(y));
    }
  } else if (picture.layout == PixelLayout::i444) {
    const auto row_of = [&](std::size_t plane, int y) {
      return picture.planes[plane].data + static_cast<std::size_t>(place.top + y) * picture.planes[plane].stride +
             place.left;
    };
    for (int y = 0; y < place.height; ++y) std::copy_n(row_of(0, y), place.width, luma_.row(y));
    for (int y = 0; y < place.height / 2; ++y) {
      pick(row_of(1, 2 * y), 2, place.width / 2, blue_.row(y));
      pick(row_of(2, 2 * y), 2, place.width / 2, red_.row(y));
    }
  } else {
    for (int y = 0; y < place.height; y += 2)
      for (int x = 0; x < place.width; x += 2) {
        glm::ivec3 sum{0};
        for (int v = 0; v < 2; ++v)
          for (int u = 0; u < 2; ++u) {
            const Rgb8 c = rgb_at(picture, place.left + x + u, place.top + y + v);
            luma_.at(x + u, y + v) = luma_of(c);
            sum += glm::ivec3(c);
          }
        blue_.at(x / 2, y / 2) = to_byte(128 + ((-11059 * sum.r - 21709 * sum.g + 32768 * sum.b + 131072) >> 18));
        red_.at(x / 2, y / 2) = to_byte(128 + ((32768 * sum.r - 27439 * sum.g - 5329 * sum.b + 131072) >> 18));
      }
  }
  cells_ = means_of_cells(luma_, blue_, red_, place.cell_px);
}

}  // namespace kasumi
