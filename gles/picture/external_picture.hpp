// A camera's picture in its driver's memory, which a GPU can read in place.
#pragma once

#include <array>
#include <cstdint>

#include "base/picture.hpp"

namespace kasumi {

struct ExternalPlane {
  std::uint32_t offset = 0;  // bytes from the buffer's beginning
  std::uint32_t stride = 0;  // bytes from one row to the next
  friend bool operator==(const ExternalPlane&, const ExternalPlane&) = default;
};

struct ExternalPicture {
  int fd = -1;               // a dma-buf; used only during the import, may be closed afterwards
  std::uint64_t buffer = 0;  // unique to the memory, so that it is imported only once
  PixelLayout layout = PixelLayout::rgb8;
  YuvEncoding encoding = YuvEncoding::bt601_full;
  int width = 0;
  int height = 0;
  std::array<ExternalPlane, 3> planes{};
};

// The fd is not compared, because it may be another duplicate for the same buffer.
inline bool same_place(const ExternalPicture& a, const ExternalPicture& b) {
  return a.buffer == b.buffer && a.layout == b.layout && a.encoding == b.encoding && a.width == b.width &&
         a.height == b.height && a.planes == b.planes;
}

}  // namespace kasumi
