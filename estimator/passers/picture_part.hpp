// A part of a camera's picture as luma and colour, whatever its layout, and its means over small cells.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

struct PartPlace {
  int left = 0, top = 0, width = 0, height = 0;  // pixels of the picture; even
  int cell_px = 4;                               // side of a cell; width and height are multiples of it
  int columns() const { return width / cell_px; }
  int rows() const { return height / cell_px; }
  bool empty() const { return width <= 0 || height <= 0; }
  friend bool operator==(const PartPlace&, const PartPlace&) = default;
};
// The part of a picture of `width` x `height` that holds a box with a margin around it, cut to whole cells:
// of 4 pixels, or of 8, 16 .. where those would be more than 6000.
PartPlace part_around(int left, int top, int right, int bottom, int margin_px, int width, int height);

// Means of Y, Cb - 128 and Cr - 128 over each cell; blue and red: of squares of 2 x 2 pixels.
Image<glm::vec3> means_of_cells(const Image<std::uint8_t>& luma, const Image<std::uint8_t>& blue,
                                const Image<std::uint8_t>& red, int cell_px);

// 8-bit values as the camera encodes them. RGB layouts are turned into full-range BT.601 values.
class PicturePart {
 public:
  // The place must lie in the picture. Reads each of its pixels once.
  void read(const PictureView& picture, const PartPlace& place);

  const PartPlace& place() const { return place_; }
  YuvEncoding encoding() const { return encoding_; }
  const Image<std::uint8_t>& luma() const { return luma_; }
  // Cb and Cr of each square of 2 x 2 pixels.
  const Image<std::uint8_t>& blue() const { return blue_; }
  const Image<std::uint8_t>& red() const { return red_; }
  // Means of Y, Cb - 128 and Cr - 128.
  const Image<glm::vec3>& cells() const { return cells_; }

 private:
  PartPlace place_;
  YuvEncoding encoding_ = YuvEncoding::bt601_full;
  Image<std::uint8_t> luma_, blue_, red_;
  Image<glm::vec3> cells_;
};

}  // namespace kasumi
