// What a V4L2 device offers: formats, sizes, rates. As the driver reports it, unchecked; nothing is set.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/v4l2/formats.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

// One size, or a range of sizes in steps.
struct V4l2Sizes {
  std::uint32_t least_width, most_width, step_width;
  std::uint32_t least_height, most_height, step_height;
  bool includes(int width, int height) const;
};

struct V4l2Interval {  // seconds as a fraction, exactly as the driver reports it
  std::uint32_t numerator = 0;
  std::uint32_t denominator = 0;
  double rate() const { return numerator == 0 ? 0.0 : static_cast<double>(denominator) / numerator; }
};

// The rates at one format and size. Empty: not reported.
struct V4l2Rates {
  std::vector<V4l2Interval> intervals;
  bool continuous = false;  // then intervals holds the shortest and the longest of a continuous range
  // The interval nearest to `rate` per second; 0: the shortest. Denominator 0: none is known.
  V4l2Interval nearest(double rate) const;
};

struct V4l2Offer {
  std::uint32_t code = 0;                   // V4L2_PIX_FMT_*
  const V4l2PixelFormat* format = nullptr;  // null: not supported
  std::vector<V4l2Sizes> sizes;             // empty: not reported
};

struct V4l2Identity {
  std::string driver, card, place;
  bool multiplanar = false;
  std::uint32_t buffer_type = 0;  // V4L2_BUF_TYPE_VIDEO_CAPTURE or .._MPLANE
};

// Errors: unsupported (not a capture device, or it does not stream), device, disconnected.
Result<V4l2Identity> identify_v4l2(VideoDevice& device);
std::vector<V4l2Offer> v4l2_offers(VideoDevice& device, std::uint32_t buffer_type);
V4l2Rates v4l2_rates(VideoDevice& device, std::uint32_t code, int width, int height);
// "YUYV: 640x480 (30, 15 /s), 1280x720 (10 /s)"
std::string describe_v4l2_offer(VideoDevice& device, const V4l2Offer& offer);

}  // namespace kasumi
