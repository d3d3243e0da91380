#include <cstdlib>

#include "base/picture_files/jpeg_input.hpp"
#include "capture/codec/encode.hpp"

namespace kasumi {

namespace {

class JpegWriter {
 public:
  JpegWriter() { info_.err = errors_.manager(); }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() {
    jpeg_destroy_compress(&info_);
    std::free(bytes_);  // libjpeg allocated it by malloc
  }

  Result<std::vector<std::uint8_t>> write(const Image<Rgb8>& image, int quality, ChromaSubsampling subsampling) {
    if (!errors_.guard([&] { write_all(image, quality, subsampling); })) {
      if (info_.dest) info_.dest->term_destination(&info_);  // updates bytes_ if the buffer was reallocated
      return fail(FaultKind::bad_input, "cannot encode a picture of {}x{} as JPEG: {}", image.width(), image.height(),
                  errors_.message());
    }
    return std::vector<std::uint8_t>(bytes_, bytes_ + size_);
  }

 private:
  void write_all(const Image<Rgb8>& image, int quality, ChromaSubsampling subsampling) {
    jpeg_create_compress(&info_);
    jpeg_mem_dest(&info_, &bytes_, &size_);
    info_.image_width = static_cast<JDIMENSION>(image.width());
    info_.image_height = static_cast<JDIMENSION>(image.height());
    info_.input_components = 3;
    info_.in_color_space = JCS_RGB;
    jpeg_set_defaults(&info_);
    jpeg_set_quality(&info_, quality, TRUE);
    if (subsampling == ChromaSubsampling::grey) jpeg_set_colorspace(&info_, JCS_GRAYSCALE);
    info_.comp_info[0].h_samp_factor =
        subsampling == ChromaSubsampling::s420 || subsampling == ChromaSubsampling::s422 ? 2 : 1;
    info_.comp_info[0].v_samp_factor = subsampling == ChromaSubsampling::s420 ? 2 : 1;
    jpeg_start_compress(&info_, TRUE);
    while (info_.next_scanline < info_.image_height) {
      auto* row = const_cast<JSAMPROW>(&image.row(static_cast<int>(info_.next_scanline))->x);  // libjpeg only reads
      jpeg_write_scanlines(&info_, &row, 1);
    }
    jpeg_finish_compress(&info_);
  }

  JpegErrors errors_;
  jpeg_compress_struct info_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

Result<std::vector<std::uint8_t>> encode_jpeg(const Image<Rgb8>& image, int quality, ChromaSubsampling subsampling) {
  if (quality < 1 || quality > 100) return fail(FaultKind::bad_input, "JPEG quality {}: expected 1 to 100", quality);
  JpegWriter writer;
  return writer.write(image, quality, subsampling);
}

}  // namespace kasumi
