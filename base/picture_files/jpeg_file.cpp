#include "base/picture_files/jpeg_errors.hpp"
#include "base/picture_files/picture_file.hpp"

namespace kasumi {

namespace {

class JpegFileReader {
 public:
  JpegFileReader() { info_.err = errors_.manager(); }
  JpegFileReader(const JpegFileReader&) = delete;
  JpegFileReader& operator=(const JpegFileReader&) = delete;
  ~JpegFileReader() { jpeg_destroy_decompress(&info_); }

  Result<DecodedFile> read(std::span<const std::uint8_t> bytes) {
    if (!errors_.guard([&] {
          jpeg_create_decompress(&info_);
          jpeg_mem_src(&info_, bytes.data(), bytes.size());
          jpeg_read_header(&info_, TRUE);
        }))
      return damaged();
    if (info_.num_components == 4)
      return fail(FaultKind::unsupported, "a JPEG of four colours, as for print: expected RGB or grey");
    if (!errors_.guard([&] {
          info_.out_color_space = info_.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
          jpeg_start_decompress(&info_);
        }))
      return damaged();
    DecodedFile file{
        static_cast<int>(info_.output_width), static_cast<int>(info_.output_height), info_.output_components, 8, {}};
    const bool several_scans = jpeg_has_multiple_scans(&info_) != 0;
    const std::size_t row_bytes = std::size_t{info_.output_width} * static_cast<std::size_t>(file.channels);
    file.samples.resize(row_bytes * info_.output_height);
    if (!errors_.guard([&] {
          while (info_.output_scanline < info_.output_height) {
            JSAMPROW row = file.samples.data() + row_bytes * info_.output_scanline;
            jpeg_read_scanlines(&info_, &row, 1);
          }
        }))
      return damaged();
    // Of several scans the last may be missing where the bytes end too early: capture's check_jpeg has the rule.
    file.whole = !several_scans && !errors_.saw_damage() && errors_.guard([&] { jpeg_finish_decompress(&info_); }) &&
                 !errors_.saw_damage();
    return file;
  }

 private:
  tl::unexpected<Fault> damaged() const { return fail(FaultKind::bad_input, "damaged JPEG: {}", errors_.message()); }

  JpegErrors errors_{JpegDamage::is_left};
  jpeg_decompress_struct info_{};
};

}  // namespace

Result<DecodedFile> decode_jpeg_file(std::span<const std::uint8_t> file) {
  JpegFileReader reader;
  return reader.read(file);
}

}  // namespace kasumi
