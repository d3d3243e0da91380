#include "capture/v4l2/frames.hpp"

#include <linux/videodev2.h>

#include <algorithm>

#include "capture/driver_time.hpp"

namespace kasumi {

namespace {

Instant captured_at(const V4l2Filled& filled, Instant now) {
  if ((filled.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return now;
  return bounded_driver_time(filled.seconds, std::clamp<std::int64_t>(filled.microseconds, 0, 999'999) * 1000);
}

// Whether every memory plane is complete.
bool gathered_whole(const V4l2Filled& filled, PixelLayout layout, const FrameMetadata& metadata,
                    const V4l2Layout& agreed) {
  for (std::size_t i = 0; i < agreed.planes.size(); ++i) {
    const auto size = plane_size(layout, metadata.width, metadata.height, static_cast<int>(i));
    const auto needed = std::size_t{agreed.planes[i].stride} * static_cast<std::size_t>(size.rows - 1) + size.row_bytes;
    if (filled.planes[i].bytes.size() < needed) return false;
  }
  return true;
}

}  // namespace

FrameMetadata v4l2_metadata(const V4l2Filled& filled, const CameraMode& mode, const V4l2Layout& layout,
                            const Clock& clock) {
  FrameMetadata metadata;
  metadata.captured_at = captured_at(filled, clock.now());
  metadata.utc = utc_of_capture(metadata.captured_at, clock);
  metadata.sequence = filled.sequence;
  metadata.format = mode.format;
  metadata.width = mode.width;
  metadata.height = mode.height;
  metadata.stride = mode.stride;
  metadata.exposure_s = mode.exposure_s;
  const bool flagged = filled.impossible || (filled.flags & V4L2_BUF_FLAG_ERROR) != 0;
  std::size_t bytes = filled.planes.front().bytes.size();
  if (layout.planes.size() > 1)
    bytes = gathered_whole(filled, *layout_of(mode.format), metadata, layout) ? bytes_needed(metadata) : 0;
  metadata.bytes_used = static_cast<std::uint32_t>(bytes);
  metadata.status = judge(metadata, bytes, flagged);
  return metadata;
}

std::vector<std::uint8_t> v4l2_bytes(const V4l2Filled& filled, const FrameMetadata& metadata,
                                     const V4l2Layout& layout) {
  const auto first = filled.planes.front().bytes;
  if (layout.planes.size() == 1) return {first.begin(), first.end()};
  if (metadata.status != FrameStatus::good) return {};
  const auto pixels = *layout_of(metadata.format);
  std::vector<std::uint8_t> gathered(metadata.bytes_used);
  std::size_t begin = 0;
  for (std::size_t i = 0; i < layout.planes.size(); ++i) {
    const auto size = plane_size(pixels, metadata.width, metadata.height, static_cast<int>(i));
    const auto stride = stride_of_plane(pixels, metadata.stride, static_cast<int>(i));
    const auto* row = filled.planes[i].bytes.data();
    for (int y = 0; y < size.rows; ++y, row += layout.planes[i].stride)
      std::copy_n(row, size.row_bytes, gathered.data() + begin + static_cast<std::size_t>(y) * stride);
    begin += static_cast<std::size_t>(size.rows) * stride;
  }
  return gathered;
}

}  // namespace kasumi
