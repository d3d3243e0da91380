// What readers of JPEGs share: libjpeg's errors, whose handler must not return, become messages. Only for the .cpp files
// that use libjpeg.
#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>  // jpeglib.h needs it and does not include it
#include <span>
#include <string>

#include <jerror.h>
#include <jpeglib.h>

namespace kasumi {

enum class JpegDamage { is_an_error, is_left };  // left: libjpeg makes something of it

class JpegErrors {
 public:
  explicit JpegErrors(JpegDamage damage = JpegDamage::is_an_error) {
    jpeg_std_error(&base_);
    base_.error_exit = [](j_common_ptr info) { leave(info); };
    base_.emit_message = [](j_common_ptr info, int level) {
      if (level < 0 && !harmless(info->err->msg_code)) leave(info);  // level < 0: a warning, the data are damaged
    };
    if (damage == JpegDamage::is_left)
      base_.emit_message = [](j_common_ptr info, int level) {
        if (level < 0 && !harmless(info->err->msg_code)) ++info->err->num_warnings;
      };
  }
  JpegErrors(const JpegErrors&) = delete;  // libjpeg keeps its address
  JpegErrors& operator=(const JpegErrors&) = delete;

  jpeg_error_mgr* manager() { return &base_; }
  const char* message() const { return message_; }
  bool saw_damage() const { return base_.num_warnings > 0; }

  // Runs `calls`; false when libjpeg reported an error. Errors longjmp out of it, so it may hold nothing with a
  // destructor.
  template <class Calls>
  bool guard(Calls&& calls) {
    if (setjmp(jump_) != 0) return false;
    calls();
    return true;
  }

 private:
  // Cameras pad between segments, write odd JFIF versions and omit the end marker. Missing pixels are still reported,
  // as JWRN_HIT_MARKER.
  static bool harmless(int code) {
    return code == JWRN_EXTRANEOUS_DATA || code == JWRN_JFIF_MAJOR || code == JWRN_JPEG_EOF;
  }
  [[noreturn]] static void leave(j_common_ptr info) {
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    errors->base_.format_message(info, errors->message_);
    std::longjmp(errors->jump_, 1);
  }

  jpeg_error_mgr base_{};  // first, so that libjpeg's pointer to it is a pointer to this
  std::jmp_buf jump_{};
  char message_[JMSG_LENGTH_MAX] = "";
};

// One JPEG that is read.
class JpegInput {
 public:
  explicit JpegInput(JpegDamage damage = JpegDamage::is_an_error) : errors_(damage) { info_.err = errors_.manager(); }
  JpegInput(const JpegInput&) = delete;
  JpegInput& operator=(const JpegInput&) = delete;
  ~JpegInput() { jpeg_destroy_decompress(&info_); }

 protected:
  bool read_header(std::span<const std::uint8_t> bytes) {
    return errors_.guard([&] {
      jpeg_create_decompress(&info_);
      jpeg_mem_src(&info_, bytes.data(), bytes.size());
      jpeg_read_header(&info_, TRUE);
    });
  }
  // To be guarded. The rows that are left, at their place in `samples`.
  void read_rows(std::uint8_t* samples) {
    const std::size_t row_bytes = std::size_t{info_.output_width} * static_cast<std::size_t>(info_.output_components);
    while (info_.output_scanline < info_.output_height) {
      JSAMPROW row = samples + row_bytes * info_.output_scanline;
      jpeg_read_scanlines(&info_, &row, 1);
    }
  }

  JpegErrors errors_;
  jpeg_decompress_struct info_{};
};

}  // namespace kasumi
