// A frame as a driver delivers it: its bytes, their format and metadata.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/jpeg_steps.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "capture/payload.hpp"

namespace kasumi {

// V4L2's four-character codes; "MJPG", "YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24" (B G R x), "AB24" (R G B
// A), "GREY".
struct FourCc {
  std::array<char, 4> code{};
  std::string text() const { return std::string(code.begin(), code.end()); }
  friend bool operator==(const FourCc&, const FourCc&) = default;
};
// Error (bad_input): none of the above.
Result<FourCc> parse_four_cc(std::string_view text);
constexpr FourCc four_cc(const char (&text)[5]) {
  return {{text[0], text[1], text[2], text[3]}};
}
constexpr FourCc kMjpg = four_cc("MJPG");
// How the pixels of an uncompressed format lie in memory; empty for MJPG and for unknown codes.
std::optional<PixelLayout> layout_of(FourCc format);

enum class FrameStatus {
  good,       // everything is valid
  flagged,    // the driver set its error flag: metadata is valid, pixels must not be shown
  truncated,  // fewer bytes than the format needs: metadata is valid, pixels are not
};
std::string_view name_of(FrameStatus status);

struct FrameMetadata {
  Instant captured_at{};       // the driver's monotonic timestamp; may repeat or go backwards with a faulty driver
  Utc utc{};                   // by the host's clock
  std::uint32_t sequence = 0;  // the driver's counter; a gap is a dropped frame
  FourCc format{};
  int width = 0;
  int height = 0;
  std::uint32_t stride = 0;      // bytes per row of the first plane; 0 for compressed formats
  std::uint32_t bytes_used = 0;  // of the payload
  std::optional<double> exposure_s;
  std::optional<double> gain;
  FrameStatus status = FrameStatus::good;
  std::uint32_t skipped = 0;  // frames since the last one delivered that the source dropped in favour of this newer one
};

// Limits on what a driver or a file may claim about a frame.
constexpr int kLargestSide = 16384;                  // pixels
constexpr std::int64_t kMaxPixels = 1 << 26;         // 64 Mpx
constexpr std::uint32_t kLargestStride = 1u << 18;   // bytes
constexpr std::uint32_t kLargestPayload = 1u << 28;  // bytes

// Whether format, size, stride and bytes_used are possible. Error (bad_input): all that are not, one per line.
Result<> check_geometry(const FrameMetadata& metadata);
// Strides of the other planes follow from the first as V4L2 defines it: NV12 the same, YU12 half, rounded up.
std::uint32_t stride_of_plane(PixelLayout layout, std::uint32_t first_stride, int plane);
// The minimum size of a complete picture, with the last row's padding excluded; for MJPG a lower bound for any JPEG of
// that size. Geometry must have been checked.
std::uint64_t bytes_needed(const FrameMetadata& metadata);
// What a source delivers the frame as. Geometry must have been checked.
FrameStatus judge(const FrameMetadata& metadata, std::size_t payload_bytes, bool driver_error);

struct Frame {
  FrameMetadata metadata;
  Payload payload;
};

// Pixels of a frame. Uncompressed formats are seen in place; JPEG is decoded to its own YUV planes (i420, i422, i444 or
// grey8) by libjpeg-turbo. Shares the payload or owns the planes, so it may outlive the frame.
class DecodedPicture {
 public:
  const PictureView& view() const { return view_; }
  // Null: the frame was no JPEG.
  const std::shared_ptr<const JpegSteps>& jpeg_steps() const { return jpeg_steps_; }
  // The picture as a GPU can import it, where it is seen in a driver's buffer.
  const std::optional<DmaBuf>& dma_buf() const { return keep_.dma_buf; }

 private:
  friend Result<DecodedPicture> decode(const Frame& frame, YuvEncoding encoding);
  PictureView view_;
  Payload keep_;
  std::shared_ptr<const JpegSteps> jpeg_steps_;
};

// `encoding` says what the YUV of uncompressed formats means; JPEG is always bt601_full.
// Errors (bad_input): status not good, payload too short for size and stride, unknown format, impossible size, damaged
// JPEG, JPEG of another size, JPEG that no camera delivers (progressive, CMYK, unusual subsampling).
Result<DecodedPicture> decode(const Frame& frame, YuvEncoding encoding);

}  // namespace kasumi
