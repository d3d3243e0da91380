#include "capture/v4l2/offer.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kasumi {

namespace {

// Limits for a driver whose enumeration never ends.
constexpr std::uint32_t kMaxFormats = 256;  // vivid has about ninety
constexpr std::uint32_t kMaxSizes = 256;
constexpr std::uint32_t kMaxIntervals = 256;

template <std::size_t N>
std::string text_of(const std::uint8_t (&field)[N]) {
  const auto* chars = reinterpret_cast<const char*>(field);
  std::string text(chars, ::strnlen(chars, N));
  for (auto& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

bool on_grid(std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
  return value >= least && value <= most && (step <= 1 || (value - least) % step == 0);
}

std::vector<V4l2Sizes> sizes_of(VideoDevice& device, std::uint32_t code) {
  std::vector<V4l2Sizes> sizes;
  for (std::uint32_t index = 0; index < kMaxSizes; ++index) {
    v4l2_frmsizeenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    if (device.control(VIDIOC_ENUM_FRAMESIZES, &entry) != 0) break;
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      const auto& size = entry.discrete;
      sizes.push_back({size.width, size.width, 1, size.height, size.height, 1});
      continue;
    }
    const auto& range = entry.stepwise;
    sizes.push_back(
        {range.min_width, range.max_width, range.step_width, range.min_height, range.max_height, range.step_height});
    break;  // there is no second one by definition
  }
  return sizes;
}

}  // namespace

bool V4l2Sizes::includes(int width, int height) const {
  return on_grid(static_cast<std::uint32_t>(width), least_width, most_width, step_width) &&
         on_grid(static_cast<std::uint32_t>(height), least_height, most_height, step_height);
}

V4l2Interval V4l2Rates::nearest(double rate) const {
  if (intervals.empty()) return {};
  const auto by_rate = [](const auto& a, const auto& b) { return a.rate() < b.rate(); };
  const auto [slowest, fastest] = std::minmax_element(intervals.begin(), intervals.end(), by_rate);
  if (rate <= 0.0) return *fastest;
  if (continuous) {
    if (rate >= fastest->rate()) return *fastest;
    if (rate <= slowest->rate()) return *slowest;
    return {1000, static_cast<std::uint32_t>(std::lround(rate * 1000.0))};
  }
  return *std::min_element(intervals.begin(), intervals.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.rate() - rate) < std::abs(b.rate() - rate);
  });
}

Result<V4l2Identity> identify_v4l2(VideoDevice& device) {
  v4l2_capability capability{};
  if (const int error = device.control(VIDIOC_QUERYCAP, &capability); error == ENOTTY || error == EINVAL)
    return fail(FaultKind::unsupported, "expected a video device");
  else if (error != 0)
    return fail(device_fault(error, "VIDIOC_QUERYCAP"));
  const auto abilities =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  V4l2Identity identity{text_of(capability.driver), text_of(capability.card), text_of(capability.bus_info)};
  identity.multiplanar = (abilities & V4L2_CAP_VIDEO_CAPTURE) == 0;
  identity.buffer_type = identity.multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if ((abilities & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0)
    return fail(FaultKind::unsupported, "{} ({}) is not a capture device", identity.card, identity.driver);
  if ((abilities & V4L2_CAP_STREAMING) == 0)
    return fail(FaultKind::unsupported, "{} ({}) does not support streaming to mapped buffers", identity.card,
                identity.driver);
  return identity;
}

std::vector<V4l2Offer> v4l2_offers(VideoDevice& device, std::uint32_t buffer_type) {
  std::vector<V4l2Offer> offers;
  for (std::uint32_t index = 0; index < kMaxFormats; ++index) {
    v4l2_fmtdesc entry{};
    entry.index = index;
    entry.type = buffer_type;
    if (device.control(VIDIOC_ENUM_FMT, &entry) != 0) break;
    const auto known = [&](const V4l2Offer& offer) { return offer.code == entry.pixelformat; };
    if (std::any_of(offers.begin(), offers.end(), known)) continue;
    offers.push_back({entry.pixelformat, find_v4l2_format(entry.pixelformat), sizes_of(device, entry.pixelformat)});
  }
  return offers;
}

V4l2Rates v4l2_rates(VideoDevice& device, std::uint32_t code, int width, int height) {
  V4l2Rates rates;
  const auto add = [&](const v4l2_fract& interval) {
    if (interval.numerator != 0 && interval.denominator != 0)
      rates.intervals.push_back({interval.numerator, interval.denominator});
  };
  for (std::uint32_t index = 0; index < kMaxIntervals; ++index) {
    v4l2_frmivalenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    entry.width = static_cast<std::uint32_t>(width);
    entry.height = static_cast<std::uint32_t>(height);
    if (device.control(VIDIOC_ENUM_FRAMEINTERVALS, &entry) != 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      add(entry.discrete);
      continue;
    }
    rates.continuous = true;
    add(entry.stepwise.min);
    add(entry.stepwise.max);
    break;
  }
  return rates;
}

std::string describe_v4l2_offer(VideoDevice& device, const V4l2Offer& offer) {
  std::string text = v4l2_format_name(offer.code) + ":";
  if (offer.sizes.empty()) text += " sizes unknown";
  for (std::size_t i = 0; i < offer.sizes.size(); ++i) {
    const auto& size = offer.sizes[i];
    text += fmt::format("{} {}x{}", i == 0 ? "" : ",", size.least_width, size.least_height);
    if (size.most_width != size.least_width || size.most_height != size.least_height)
      text += fmt::format("..{}x{}", size.most_width, size.most_height);
    const auto rates =
        v4l2_rates(device, offer.code, static_cast<int>(size.most_width), static_cast<int>(size.most_height));
    if (rates.intervals.empty()) continue;
    text += " (";
    for (std::size_t j = 0; j < rates.intervals.size(); ++j)
      text += fmt::format("{}{:.4g}", j == 0 ? "" : (rates.continuous ? ".." : ", "), rates.intervals[j].rate());
    text += " /s)";
  }
  return text;
}

}  // namespace kasumi
