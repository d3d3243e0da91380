#include "base/picture_files/jpeg_input.hpp"
#include "base/picture_files/picture_file.hpp"

namespace kasumi {

namespace {

class JpegFileReader : JpegInput {
 public:
  JpegFileReader() : JpegInput(JpegDamage::is_left) {}

  Result<DecodedFile> read(std::span<const std::uint8_t> bytes) {
    if (!read_header(bytes)) return damaged();
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
    file.samples.resize(std::size_t{info_.output_width} * static_cast<std::size_t>(file.channels) *
                        info_.output_height);
    if (!errors_.guard([&] { read_rows(file.samples.data()); })) return damaged();
    // Of several scans the last may be missing where the bytes end too early: capture's check_jpeg has the rule.
    file.whole = !several_scans && !errors_.saw_damage() && errors_.guard([&] { jpeg_finish_decompress(&info_); }) &&
                 !errors_.saw_damage();
    return file;
  }

 private:
  tl::unexpected<Fault> damaged() const { return fail(FaultKind::bad_input, "damaged JPEG: {}", errors_.message()); }
};

}  // namespace

Result<DecodedFile> decode_jpeg_file(std::span<const std::uint8_t> file) {
  JpegFileReader reader;
  return reader.read(file);
}

}  // namespace kasumi
