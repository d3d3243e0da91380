#include "capture/v4l2/negotiation.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kasumi {

namespace {

struct Candidate {
  const V4l2PixelFormat* format;
  V4l2Interval interval;
};

// Rates that differ by less than a percent count as equal (30 and 29.97), and unknown rates as matching.
long rate_gap(const Candidate& candidate, double wanted_rate) {
  const double rate = candidate.interval.rate();
  return rate == 0.0 ? 0 : std::lround(50.0 * std::abs(rate - wanted_rate) / wanted_rate);
}

std::string asked_for(const CameraRequest& request) {
  return fmt::format("{}{}x{}", request.format ? request.format->text() + " " : "", request.width, request.height);
}

std::vector<Candidate> candidates(VideoDevice& device, const std::vector<V4l2Offer>& offers,
                                  const CameraRequest& request) {
  std::vector<Candidate> found;
  for (const auto& offer : offers) {
    if (!offer.format || (request.format && offer.format->format != *request.format)) continue;
    const auto fits = [&](const V4l2Sizes& sizes) { return sizes.includes(request.width, request.height); };
    if (!offer.sizes.empty() && std::none_of(offer.sizes.begin(), offer.sizes.end(), fits)) continue;
    const auto rates = v4l2_rates(device, offer.code, request.width, request.height);
    found.push_back({offer.format, rates.nearest(request.frames_per_second)});
  }
  double wanted_rate = request.frames_per_second;
  for (const auto& candidate : found)
    if (request.frames_per_second <= 0.0) wanted_rate = std::max(wanted_rate, candidate.interval.rate());
  const auto order = [&](const Candidate& c) {
    return std::tuple(!c.format->colour, rate_gap(c, wanted_rate), c.format->cost);
  };
  std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) { return order(a) < order(b); });
  return found;
}

Fault nothing_fits(VideoDevice& device, const std::vector<V4l2Offer>& offers, const CameraRequest& request) {
  std::string message = asked_for(request) + ": the camera does not offer it; it offers";
  std::string unread;
  bool any = false;
  for (const auto& offer : offers) {
    if (offer.format) message += "\n  " + describe_v4l2_offer(device, offer);
    if (!offer.format) unread += (unread.empty() ? "" : ", ") + v4l2_format_name(offer.code);
    any = any || offer.format;
  }
  if (!any) message += " no supported format";
  if (!unread.empty()) message += "\n  and, not supported: " + unread;
  return {FaultKind::bad_input, std::move(message)};
}

// v4l2_format for both single- and multi-planar devices.
struct Answer {
  std::uint32_t width, height, code, field, colour_space, ycbcr_encoding, quantization;
  std::vector<V4l2Layout::MemoryPlane> planes;
};

Answer answer_of(const v4l2_format& format) {
  if (!V4L2_TYPE_IS_MULTIPLANAR(format.type)) {
    const auto& pix = format.fmt.pix;
    return {pix.width,      pix.height,    pix.pixelformat,  pix.field,
            pix.colorspace, pix.ycbcr_enc, pix.quantization, {{pix.bytesperline, pix.sizeimage}}};
  }
  const auto& pix = format.fmt.pix_mp;
  Answer answer{pix.width, pix.height, pix.pixelformat, pix.field, pix.colorspace, pix.ycbcr_enc, pix.quantization, {}};
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(pix.num_planes, VIDEO_MAX_PLANES); ++i)
    answer.planes.push_back({pix.plane_fmt[i].bytesperline, pix.plane_fmt[i].sizeimage});
  return answer;
}

v4l2_format request_of(std::uint32_t buffer_type, const V4l2PixelFormat& wanted, const CameraRequest& request) {
  v4l2_format format{};
  format.type = buffer_type;
  const auto width = static_cast<std::uint32_t>(request.width), height = static_cast<std::uint32_t>(request.height);
  if (V4L2_TYPE_IS_MULTIPLANAR(buffer_type)) {
    format.fmt.pix_mp.width = width;
    format.fmt.pix_mp.height = height;
    format.fmt.pix_mp.pixelformat = wanted.code;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
    format.fmt.pix_mp.num_planes = static_cast<std::uint8_t>(wanted.planes);
  } else {
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = wanted.code;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.priv = V4L2_PIX_FMT_PRIV_MAGIC;  // without it the kernel does not report colour metadata
  }
  return format;
}

// The driver's strides and sizes, checked to be large enough for the picture.
Result<std::vector<V4l2Layout::MemoryPlane>> checked_planes(const Answer& answer, const V4l2PixelFormat& format) {
  auto planes = answer.planes;
  if (planes.size() != format.planes)
    return fail(FaultKind::device, "VIDIOC_S_FMT: {} memory planes for {}: expected {}", planes.size(),
                v4l2_format_name(format.code), format.planes);
  for (const auto& plane : planes)
    if (plane.size > kLargestPayload)
      return fail(FaultKind::device, "VIDIOC_S_FMT: {} bytes for a picture: expected at most {}", plane.size,
                  kLargestPayload);
  const auto layout = layout_of(format.format);
  FrameMetadata metadata;
  metadata.format = format.format;
  metadata.width = static_cast<int>(answer.width);
  metadata.height = static_cast<int>(answer.height);
  if (!layout) {
    planes[0].stride = 0;
    if (planes[0].size == 0) return fail(FaultKind::device, "VIDIOC_S_FMT: 0 bytes for a picture");
    return planes;
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto size = plane_size(*layout, metadata.width, metadata.height, static_cast<int>(i));
    auto& plane = planes[i];
    if (plane.stride == 0) plane.stride = static_cast<std::uint32_t>(size.row_bytes);  // old drivers: packed
    if (plane.stride < size.row_bytes || plane.stride > kLargestStride)
      return fail(FaultKind::device, "VIDIOC_S_FMT: {} bytes in a row of {} of {} pixels: expected {} to {}",
                  plane.stride, v4l2_format_name(format.code), metadata.width, size.row_bytes, kLargestStride);
    metadata.stride = planes[0].stride;
    const auto rows = static_cast<std::uint64_t>(size.rows);
    const auto needed =
        planes.size() == 1 ? bytes_needed(metadata) : std::uint64_t{plane.stride} * (rows - 1) + size.row_bytes;
    if (plane.size < needed)
      return fail(FaultKind::device, "VIDIOC_S_FMT: {} bytes for a picture that takes {}", plane.size, needed);
  }
  return planes;
}

void set_rate(VideoDevice& device, std::uint32_t buffer_type, V4l2Interval interval, double wanted, CameraMode& mode) {
  v4l2_streamparm parameters{};
  parameters.type = buffer_type;
  auto& capture = parameters.parm.capture;
  const bool known =
      device.control(VIDIOC_G_PARM, &parameters) == 0 && (capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  if (interval.denominator == 0 && wanted > 0.0)
    interval = {1000, static_cast<std::uint32_t>(std::lround(std::min(wanted, 1000.0) * 1000.0))};
  if (known && interval.denominator != 0) {
    capture.timeperframe = {interval.numerator, interval.denominator};
    parameters.type = buffer_type;
    if (device.control(VIDIOC_S_PARM, &parameters) != 0) {
      mode.notes.push_back("frame rate: the driver refuses to set it");
      if (device.control(VIDIOC_G_PARM, &parameters) != 0) return;
    }
  }
  if (known && capture.timeperframe.numerator != 0)
    mode.frames_per_second = static_cast<double>(capture.timeperframe.denominator) / capture.timeperframe.numerator;
  if (wanted <= 0.0) return;
  if (mode.frames_per_second == 0.0)
    mode.notes.push_back(
        fmt::format("frame rate {:.4g} /s requested: the driver does not report the actual rate", wanted));
  else if (std::abs(mode.frames_per_second - wanted) > 0.01 * wanted)
    mode.notes.push_back(
        fmt::format("frame rate {:.4g} /s requested: the camera delivers {:.4g} /s", wanted, mode.frames_per_second));
}

}  // namespace

bool V4l2Layout::multiplanar() const {
  return V4L2_TYPE_IS_MULTIPLANAR(buffer_type);
}

Result<V4l2Agreement> negotiate_v4l2(VideoDevice& device, const V4l2Identity& identity, const CameraRequest& request) {
  const auto offers = v4l2_offers(device, identity.buffer_type);
  const auto possible = candidates(device, offers, request);
  if (possible.empty()) return fail(nothing_fits(device, offers, request));

  // A driver that does not enumerate its sizes may still refuse; then the next best format is tried.
  std::string refused;
  for (const auto& candidate : possible) {
    auto format = request_of(identity.buffer_type, *candidate.format, request);
    const int error = device.control(VIDIOC_S_FMT, &format);
    if (error == EINVAL) continue;
    if (error != 0) return fail(device_fault(error, "VIDIOC_S_FMT"));
    const auto answer = answer_of(format);
    const auto name = v4l2_format_name(answer.code);
    if (answer.code != candidate.format->code || answer.width != static_cast<std::uint32_t>(request.width) ||
        answer.height != static_cast<std::uint32_t>(request.height)) {
      refused = fmt::format(" (it would give {} {}x{})", name, answer.width, answer.height);
      continue;
    }
    auto planes = checked_planes(answer, *candidate.format);
    if (!planes) return fail(planes.error());

    V4l2Agreement agreement;
    auto& mode = agreement.mode;
    mode.format = candidate.format->format;
    mode.width = request.width;
    mode.height = request.height;
    mode.stride = planes->front().stride;
    mode.driver = identity.driver;
    mode.card = identity.card;
    mode.place = identity.place;
    mode.yuv_encoding = v4l2_yuv_encoding(mode.format, answer.colour_space, answer.ycbcr_encoding, answer.quantization);
    agreement.layout = {identity.buffer_type, std::move(*planes), identity.driver == "v4l2 loopback"};
    if (answer.field != V4L2_FIELD_NONE && answer.field != V4L2_FIELD_ANY) {
      if (answer.field != V4L2_FIELD_INTERLACED && answer.field != V4L2_FIELD_INTERLACED_TB &&
          answer.field != V4L2_FIELD_INTERLACED_BT)
        return fail(FaultKind::bad_input, "{}: the camera delivers single fields: expected whole frames",
                    asked_for(request));
      mode.notes.push_back("the picture is interlaced: moving edges show combing");
    }
    if (request.yuv_encoding && mode.yuv_encoding && *request.yuv_encoding != *mode.yuv_encoding)
      mode.notes.push_back(fmt::format("yuv_encoding: the driver reports {}, overridden by calibration: {}",
                                       name_of(*mode.yuv_encoding), name_of(*request.yuv_encoding)));
    set_rate(device, identity.buffer_type, candidate.interval, request.frames_per_second, mode);
    return agreement;
  }
  auto fault = nothing_fits(device, offers, request);
  if (!refused.empty()) fault.message.insert(fault.message.find(':'), refused);
  return fail(std::move(fault));
}

}  // namespace kasumi
