#include <vector>

#include "base/picture_files/jpeg_input.hpp"
#include "capture/codec/jpeg.hpp"

namespace kasumi {

namespace {

class JpegChecker : JpegInput {
 public:
  Result<> check(std::span<const std::uint8_t> bytes);

 private:
  tl::unexpected<Fault> damaged() const {
    return fail(FaultKind::bad_input, "damaged JPEG: {} of {} rows are whole ({})", row(), info_.image_height,
                errors_.message());
  }
  // Of the picture, from which an eighth is computed.
  JDIMENSION row() const {
    return info_.output_height == 0 ? 0 : info_.output_scanline * info_.image_height / info_.output_height;
  }

  std::vector<std::uint8_t> samples_;
  JSAMPROW line_ = nullptr;
  bool several_scans_ = false;
};

Result<> JpegChecker::check(std::span<const std::uint8_t> bytes) {
  if (!read_header(bytes) || !errors_.guard([&] {
        // All of the code is read, and as little as possible is made of it.
        info_.scale_num = 1;
        info_.scale_denom = 8;
        info_.out_color_space = info_.jpeg_color_space;
        jpeg_start_decompress(&info_);
        several_scans_ = jpeg_has_multiple_scans(&info_) != 0;
      }))
    return damaged();
  samples_.resize(static_cast<std::size_t>(info_.output_width) * static_cast<std::size_t>(info_.output_components));
  line_ = samples_.data();
  if (!errors_.guard([this] {
        while (info_.output_scanline < info_.output_height) jpeg_read_scanlines(&info_, &line_, 1);
        jpeg_finish_decompress(&info_);
      }))
    return damaged();
  // Where the bytes end too early, libjpeg goes on with an end marker of its own. A camera's single scan may well do
  // without one; of several scans the last are missing then.
  const auto* at = info_.src->next_input_byte;
  const bool inside = at >= bytes.data() && at <= bytes.data() + bytes.size();
  if (!inside && several_scans_) return fail(FaultKind::bad_input, "damaged JPEG: its finer scans are missing");
  return {};
}

}  // namespace

Result<> check_jpeg(std::span<const std::uint8_t> bytes) {
  JpegChecker checker;
  return checker.check(bytes);
}

}  // namespace kasumi
