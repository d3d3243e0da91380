// One frame as a driver delivers it: bytes with a format, and what is known about them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

// V4L2's four-character codes; "MJPG", "YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24" (B G R x), "AB24" (R G B
// A), "GREY".
struct FourCc {
  std::array<char, 4> code{};
  std::string text() const { return std::string(code.begin(), code.end()); }
  friend bool operator==(const FourCc&, const FourCc&) = default;
};
Result<FourCc> parse_four_cc(std::string_view text);

enum class FrameStatus {
  good,       // everything is valid
  flagged,    // the driver set its error flag: metadata is valid, pixels are not to be shown
  truncated,  // fewer bytes than the format needs, or none: metadata is valid, pixels are not
};
std::string_view name_of(FrameStatus status);

struct FrameMetadata {
  Instant captured_at{};  // the driver's monotonic timestamp; may repeat or run backwards when the driver misbehaves
  Utc utc{};              // as the host's clock had it then
  std::uint32_t sequence = 0;  // the driver's counter; a gap is a dropped frame
  FourCc format{};
  int width = 0;
  int height = 0;
  std::uint32_t stride = 0;      // bytes per row of the first plane; 0 for compressed formats
  std::uint32_t bytes_used = 0;  // of the payload
  std::optional<double> exposure_s;
  std::optional<double> gain;
  FrameStatus status = FrameStatus::good;
};

struct Frame {
  FrameMetadata metadata;
  std::shared_ptr<const std::vector<std::uint8_t>> payload;  // never null; may be empty
};

// Pixels of a frame. Uncompressed formats are seen in place (keep the frame); JPEG is decoded to its own YUV planes by
// libjpeg-turbo. Owns whatever it needs.
class DecodedPicture {
 public:
  const PictureView& view() const { return view_; }

 private:
  friend Result<DecodedPicture> decode(const Frame& frame, YuvEncoding encoding);
  PictureView view_;
  std::shared_ptr<const std::vector<std::uint8_t>> keep_;
};

// `encoding` says what the YUV of uncompressed formats means; JPEG is always bt601_full.
// Errors (bad_input): status not good, payload too short for size and stride, unknown format, damaged JPEG, JPEG of
// another size.
Result<DecodedPicture> decode(const Frame& frame, YuvEncoding encoding);

}  // namespace kasumi
