#include "base/picture_files/small_jpeg.hpp"

#include "base/picture_files/jpeg_input.hpp"

namespace kasumi {

namespace {

class SmallJpegReader : JpegInput {
 public:
  std::optional<DecodedFile> read(std::span<const std::uint8_t> bytes) {
    if (!read_header(bytes)) return std::nullopt;
    if (info_.num_components != 3 || jpeg_has_multiple_scans(&info_) != 0) return std::nullopt;
    if (!errors_.guard([&] {
          info_.scale_num = 1;
          info_.scale_denom = kSmallJpegShrink;
          info_.out_color_space = JCS_RGB;
          jpeg_start_decompress(&info_);
        }))
      return std::nullopt;
    DecodedFile file{static_cast<int>(info_.output_width), static_cast<int>(info_.output_height), 3, 8, {}, true};
    file.samples.resize(std::size_t{info_.output_width} * 3 * info_.output_height);
    if (!errors_.guard([&] {
          read_rows(file.samples.data());
          jpeg_finish_decompress(&info_);
        }))
      return std::nullopt;
    return file;
  }
};

}  // namespace

std::optional<DecodedFile> decode_small_jpeg(std::span<const std::uint8_t> file) {
  SmallJpegReader reader;
  return reader.read(file);
}

}  // namespace kasumi
