// JPEGs that Kasumi itself does not write, made by libjpeg.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

#include <jpeglib.h>

#include "base/picture.hpp"

namespace kasumi {

// `change` may alter any setting after the defaults and before the first row.
inline std::vector<std::uint8_t> exotic_jpeg(const Image<Rgb8>& image,
                                             const std::function<void(jpeg_compress_struct&)>& change) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(image.width());
  info.image_height = static_cast<JDIMENSION>(image.height());
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 90, TRUE);
  change(info);
  jpeg_start_compress(&info, TRUE);
  const auto samples = static_cast<std::size_t>(info.input_components);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(image.width()) * samples);
  while (info.next_scanline < info.image_height) {
    for (int x = 0; x < image.width(); ++x)
      for (std::size_t c = 0; c < samples; ++c)
        row[static_cast<std::size_t>(x) * samples + c] =
            image.at(x, static_cast<int>(info.next_scanline))[static_cast<int>(c % 3)];
    JSAMPROW start = row.data();
    jpeg_write_scanlines(&info, &start, 1);
  }
  jpeg_finish_compress(&info);
  std::vector<std::uint8_t> result(bytes, bytes + size);
  jpeg_destroy_compress(&info);
  std::free(bytes);
  return result;
}

// Webcams omit the Huffman tables when they are the standard ones.
inline std::vector<std::uint8_t> without_huffman_tables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> result(jpeg.begin(), jpeg.begin() + 2);
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const std::size_t length = 2 + jpeg[at + 2] * 256u + jpeg[at + 3];
    const bool scan = jpeg[at + 1] == 0xDA;
    const auto end = scan ? jpeg.size() : at + length;
    if (jpeg[at + 1] != 0xC4)
      result.insert(result.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                    jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    at = end;
  }
  return result;
}

}  // namespace kasumi
