#include "capture/codec/dimmed_picture.hpp"

#include <cmath>

namespace kasumi {

namespace {

using DimTable = std::array<std::uint8_t, 256>;

// Values keep their distance from `still`, dimmed.
DimTable dim_table(double still) {
  DimTable table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint8_t>(std::lround(still + kDimmed * (static_cast<double>(i) - still)));
  return table;
}

void dim_plane(const Plane& from, const PlaneSize& size, const DimTable& even, const DimTable& odd,
               std::vector<std::uint8_t>& to) {
  to.resize(size.row_bytes * static_cast<std::size_t>(size.rows));
  for (int row = 0; row < size.rows; ++row) {
    const auto* in = from.data + static_cast<std::size_t>(row) * from.stride;
    auto* out = to.data() + static_cast<std::size_t>(row) * size.row_bytes;
    std::size_t i = 0;
    for (; i + 1 < size.row_bytes; i += 2) {
      out[i] = even[in[i]];
      out[i + 1] = odd[in[i + 1]];
    }
    if (i < size.row_bytes) out[i] = even[in[i]];
  }
}

}  // namespace

const PictureView& DimmedPicture::dim(const PictureView& picture) {
  const bool rgb = picture.layout <= PixelLayout::bgra8;
  const double black = rgb ? 0.0 : 255.0 * static_cast<double>(yuv_to_rgb(picture.encoding).offset.x);
  const DimTable light = dim_table(black), colour = dim_table(128.0);
  view_ = picture;
  for (std::size_t i = 0; i < static_cast<std::size_t>(plane_count(picture.layout)); ++i) {
    const auto size = plane_size(picture.layout, picture.width, picture.height, static_cast<int>(i));
    const bool is_colour = i > 0;
    const DimTable& even = is_colour || picture.layout == PixelLayout::uyvy ? colour : light;
    const DimTable& odd = is_colour || picture.layout == PixelLayout::yuyv ? colour : light;
    dim_plane(picture.planes[i], size, even, odd, bytes_[i]);
    view_.planes[i] = {bytes_[i].data(), size.row_bytes};
  }
  return view_;
}

}  // namespace kasumi
