#include "base/picture_files/small_jpeg.hpp"

#include "base/picture_files/jpeg_errors.hpp"

namespace kasumi {

namespace {

class SmallJpegReader {
 public:
  SmallJpegReader() { info_.err = errors_.manager(); }
  SmallJpegReader(const SmallJpegReader&) = delete;
  SmallJpegReader& operator=(const SmallJpegReader&) = delete;
  ~SmallJpegReader() { jpeg_destroy_decompress(&info_); }

  std::optional<DecodedFile> read(std::span<const std::uint8_t> bytes) {
    if (!errors_.guard([&] {
          jpeg_create_decompress(&info_);
          jpeg_mem_src(&info_, bytes.data(), bytes.size());
          jpeg_read_header(&info_, TRUE);
        }))
      return std::nullopt;
    if (info_.num_components != 3 || jpeg_has_multiple_scans(&info_) != 0) return std::nullopt;
    if (!errors_.guard([&] {
          info_.scale_num = 1;
          info_.scale_denom = kSmallJpegShrink;
          info_.out_color_space = JCS_RGB;
          jpeg_start_decompress(&info_);
        }))
      return std::nullopt;
    DecodedFile file{static_cast<int>(info_.output_width), static_cast<int>(info_.output_height), 3, 8, {}, true};
    const std::size_t row_bytes = std::size_t{info_.output_width} * 3;
    file.samples.resize(row_bytes * info_.output_height);
    if (!errors_.guard([&] {
          while (info_.output_scanline < info_.output_height) {
            JSAMPROW row = file.samples.data() + row_bytes * info_.output_scanline;
            jpeg_read_scanlines(&info_, &row, 1);
          }
          jpeg_finish_decompress(&info_);
        }))
      return std::nullopt;
    return file;
  }

 private:
  JpegErrors errors_;
  jpeg_decompress_struct info_{};
};

}  // namespace

std::optional<DecodedFile> decode_small_jpeg(std::span<const std::uint8_t> file) {
  SmallJpegReader reader;
  return reader.read(file);
}

}  // namespace kasumi
