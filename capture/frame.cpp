#include "capture/frame.hpp"

#include <algorithm>

namespace kasumi {

namespace {

struct Format {
  FourCc code;
  std::optional<PixelLayout> layout;
};

constexpr std::array<Format, 10> kFormats{{
    {kMjpg, std::nullopt},
    {four_cc("YUYV"), PixelLayout::yuyv},
    {four_cc("UYVY"), PixelLayout::uyvy},
    {four_cc("NV12"), PixelLayout::nv12},
    {four_cc("YU12"), PixelLayout::i420},
    {four_cc("RGB3"), PixelLayout::rgb8},
    {four_cc("BGR3"), PixelLayout::bgr8},
    {four_cc("XR24"), PixelLayout::bgra8},
    {four_cc("AB24"), PixelLayout::rgba8},
    {four_cc("GREY"), PixelLayout::grey8},
}};

const Format* find(FourCc code) {
  const auto found = std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.code == code; });
  return found == kFormats.end() ? nullptr : &*found;
}

std::string known_codes() {
  std::string list;
  for (const auto& format : kFormats) list += (list.empty() ? "" : ", ") + format.code.text();
  return list;
}

std::string printable(std::string_view text) {
  std::string shown(text.substr(0, 16));
  for (auto& c : shown)
    if (c < ' ' || c > '~') c = '?';
  return shown;
}

}  // namespace

Result<FourCc> parse_four_cc(std::string_view text) {
  for (const auto& format : kFormats)
    if (format.code.text() == text) return format.code;
  return fail(FaultKind::bad_input, "\"{}\": expected one of {}", printable(text), known_codes());
}

std::optional<PixelLayout> layout_of(FourCc format) {
  const auto* known = find(format);
  return known ? known->layout : std::nullopt;
}

std::string_view name_of(FrameStatus status) {
  switch (status) {
    case FrameStatus::good: return "good";
    case FrameStatus::flagged: return "flagged";
    case FrameStatus::truncated: return "truncated";
  }
  return "unknown";
}

Result<> check_geometry(const FrameMetadata& metadata) {
  Problems problems;
  const auto& [width, height] = std::pair{metadata.width, metadata.height};
  const auto* format = find(metadata.format);
  if (!format) problems.add("format \"{}\": expected one of {}", printable(metadata.format.text()), known_codes());
  const bool sides_fit = width >= 1 && height >= 1 && width <= kLargestSide && height <= kLargestSide;
  if (!sides_fit)
    problems.add("size {}x{}: expected 1 to {} pixels each way", width, height, kLargestSide);
  else if (std::int64_t{width} * height > kMaxPixels)
    problems.add("size {}x{}: expected at most {} pixels", width, height, kMaxPixels);
  if (metadata.stride > kLargestStride)
    problems.add("stride {}: expected at most {} bytes", metadata.stride, kLargestStride);
  else if (format && format->layout && sides_fit) {
    const auto row_bytes = plane_size(*format->layout, width, height, 0).row_bytes;
    if (metadata.stride < row_bytes)
      problems.add("stride {}: expected at least {} bytes for a row of {} pixels {}", metadata.stride, row_bytes, width,
                   metadata.format.text());
  }
  if (metadata.bytes_used > kLargestPayload)
    problems.add("bytes_used {}: expected at most {}", metadata.bytes_used, kLargestPayload);
  if (problems.empty()) return {};
  return fail(problems.fault());
}

std::uint64_t bytes_needed(const FrameMetadata& metadata) {
  const auto layout = layout_of(metadata.format);
  if (!layout) {
    // A Huffman code takes at least one bit, and a block of 64 samples at least two codes.
    const auto pixels = static_cast<std::uint64_t>(metadata.width) * static_cast<std::uint64_t>(metadata.height);
    return std::max<std::uint64_t>(1, pixels / 256);
  }
  std::uint64_t bytes = 0;
  for (int plane = 0; plane < plane_count(*layout); ++plane) {
    const auto size = plane_size(*layout, metadata.width, metadata.height, plane);
    const std::uint64_t stride = stride_of_plane(*layout, metadata.stride, plane);
    const auto rows = static_cast<std::uint64_t>(size.rows);
    bytes += plane + 1 < plane_count(*layout) ? stride * rows : stride * (rows - 1) + size.row_bytes;
  }
  return bytes;
}

std::uint32_t stride_of_plane(PixelLayout layout, std::uint32_t first_stride, int plane) {
  if (plane == 0) return first_stride;
  switch (layout) {
    case PixelLayout::nv12: return first_stride + first_stride % 2;
    case PixelLayout::i420:
    case PixelLayout::i422: return first_stride / 2 + first_stride % 2;
    default: return first_stride;
  }
}

FrameStatus judge(const FrameMetadata& metadata, std::size_t payload_bytes, bool driver_error) {
  if (driver_error) return FrameStatus::flagged;
  const bool whole = payload_bytes >= metadata.bytes_used && metadata.bytes_used >= bytes_needed(metadata);
  return whole ? FrameStatus::good : FrameStatus::truncated;
}

}  // namespace kasumi
