#include "capture/libcamera/setup.hpp"

#include <algorithm>
#include <array>

#include <libcamera/formats.h>

namespace kasumi {

namespace {

struct Known {
  libcamera::PixelFormat drm;  // DRM names channels from the highest bits of a word, V4L2 in memory order
  FourCc ours;
};

// Cheapest first: fewest bytes to transfer, chroma as the GPU samples it.
const std::array kKnown{
    Known{libcamera::formats::NV12, four_cc("NV12")},
    Known{libcamera::formats::YUV420, four_cc("YU12")},
    Known{libcamera::formats::YUYV, four_cc("YUYV")},
    Known{libcamera::formats::UYVY, four_cc("UYVY")},
    Known{libcamera::formats::RGB888, four_cc("BGR3")},
    Known{libcamera::formats::BGR888, four_cc("RGB3")},
    Known{libcamera::formats::XRGB8888, four_cc("XR24")},
    Known{libcamera::formats::ARGB8888, four_cc("XR24")},
    Known{libcamera::formats::XBGR8888, four_cc("AB24")},
    Known{libcamera::formats::ABGR8888, four_cc("AB24")},
    Known{libcamera::formats::MJPEG, kMjpg},
    Known{libcamera::formats::R8, four_cc("GREY")},
};

std::string offer(const libcamera::StreamConfiguration& stream) {
  std::string words;
  for (const auto& format : stream.formats().pixelformats()) {
    const auto range = stream.formats().range(format);
    words += fmt::format("{}{} {}..{}", words.empty() ? "" : ", ", format.toString(), range.min.toString(),
                         range.max.toString());
  }
  return words.empty() ? stream.toString() : words;
}

}  // namespace

std::optional<FourCc> four_cc_of(const libcamera::PixelFormat& format) {
  const auto found = std::ranges::find(kKnown, format, &Known::drm);
  return found == kKnown.end() ? std::nullopt : std::optional(found->ours);
}

Result<std::unique_ptr<libcamera::CameraConfiguration>> choose_configuration(libcamera::Camera& camera,
                                                                             const CameraRequest& request) {
  auto configuration = camera.generateConfiguration({libcamera::StreamRole::Viewfinder});
  if (!configuration || configuration->empty())
    return fail(FaultKind::device, "{}: offers no viewfinder stream", camera.id());
  auto& stream = configuration->at(0);
  const auto offered = stream.formats().pixelformats();
  const libcamera::Size size(static_cast<unsigned>(request.width), static_cast<unsigned>(request.height));
  std::string nearest;  // a size range has steps that libcamera reveals only by adjusting a request
  for (const auto& known : kKnown) {
    if (request.format && known.ours != *request.format) continue;
    if (!offered.empty() && std::ranges::find(offered, known.drm) == offered.end()) continue;
    stream.pixelFormat = known.drm;
    stream.size = size;
    stream.bufferCount = static_cast<unsigned>(request.buffers);
    if (configuration->validate() == libcamera::CameraConfiguration::Invalid) continue;
    if (stream.pixelFormat == known.drm && stream.size == size) return configuration;
    if (nearest.empty())
      nearest = fmt::format("; nearest: {} {}", stream.pixelFormat.toString(), stream.size.toString());
  }
  return fail(FaultKind::bad_input, "{}: {} {}x{}: expected one of: {}{}", camera.id(),
              request.format ? request.format->text() : "any format", request.width, request.height, offer(stream),
              nearest);
}

libcamera::ControlList controls_for(const libcamera::Camera& camera, const CameraRequest& request,
                                    std::vector<std::string>& notes) {
  namespace controls = libcamera::controls;
  libcamera::ControlList list(camera.controls());
  const auto offers = [&](const auto& control) { return camera.controls().count(control.id()) > 0; };
  const auto set = [&](const auto& control, auto value, std::string_view asked) {
    if (offers(control))
      list.set(control, value);
    else
      notes.push_back(fmt::format("{}: the camera has no such control ({})", asked, control.name()));
  };
  if (request.frames_per_second > 0) {
    const auto duration = static_cast<std::int64_t>(1e6 / request.frames_per_second);  // microseconds
    if (offers(controls::FrameDurationLimits))
      list.set(controls::FrameDurationLimits, {duration, duration});
    else
      notes.push_back(fmt::format("frames_per_second = {}: the camera keeps its own rate", request.frames_per_second));
  }
  if (request.exposure_s || request.gain) {
    if (offers(controls::AeEnable)) list.set(controls::AeEnable, false);
    if (request.exposure_s)
      set(controls::ExposureTime, static_cast<std::int32_t>(*request.exposure_s * 1e6), "exposure_s");
    if (request.gain) set(controls::AnalogueGain, static_cast<float>(*request.gain), "gain");
  }
  if (request.white_balance_k) {
    if (offers(controls::ColourTemperature) && offers(controls::AwbEnable)) {
      list.set(controls::AwbEnable, false);
      list.set(controls::ColourTemperature, static_cast<std::int32_t>(*request.white_balance_k));
    } else {
      notes.push_back(
          fmt::format("white_balance_k = {}: the camera takes no colour temperature; its own is locked instead",
                      *request.white_balance_k));
    }
  }
  return list;
}

libcamera::ControlList white_balance_lock(const libcamera::Camera& camera, const libcamera::ControlList& metadata) {
  namespace controls = libcamera::controls;
  libcamera::ControlList list(camera.controls());
  const auto gains = metadata.get(controls::ColourGains);
  if (!gains || camera.controls().count(controls::AwbEnable.id()) == 0 ||
      camera.controls().count(controls::ColourGains.id()) == 0)
    return list;
  list.set(controls::AwbEnable, false);
  list.set(controls::ColourGains, {(*gains)[0], (*gains)[1]});
  return list;
}

}  // namespace kasumi
