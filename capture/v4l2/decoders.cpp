#include "capture/v4l2/decoders.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>

#include "capture/v4l2/formats.hpp"

namespace kasumi {

namespace {

constexpr std::uint32_t kMostFormats = 256;  // for a driver whose enumeration never ends

std::vector<std::string> formats_of(VideoDevice& device, std::uint32_t buffer_type, bool only_compressed) {
  std::vector<std::string> names;
  for (std::uint32_t index = 0; index < kMostFormats; ++index) {
    v4l2_fmtdesc entry{};
    entry.index = index;
    entry.type = buffer_type;
    if (device.control(VIDIOC_ENUM_FMT, &entry) != 0) break;
    auto name = v4l2_format_name(entry.pixelformat);
    const bool wanted = !only_compressed || (entry.flags & V4L2_FMT_FLAG_COMPRESSED) != 0;
    if (wanted && std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

std::optional<V4l2Decoder> decoder_of(VideoDevice& device) {
  v4l2_capability capability{};
  if (device.control(VIDIOC_QUERYCAP, &capability) != 0) return std::nullopt;
  const auto abilities =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  const bool planar = (abilities & V4L2_CAP_VIDEO_M2M_MPLANE) != 0;
  if (!planar && (abilities & V4L2_CAP_VIDEO_M2M) == 0) return std::nullopt;
  const auto* driver = reinterpret_cast<const char*>(capability.driver);
  V4l2Decoder decoder{
      std::string(driver, ::strnlen(driver, sizeof capability.driver)),
      formats_of(device, planar ? V4L2_BUF_TYPE_VIDEO_OUTPUT_MPLANE : V4L2_BUF_TYPE_VIDEO_OUTPUT, true),
      formats_of(device, planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE, false)};
  std::ranges::replace_if(
      decoder.driver, [](char c) { return c < ' ' || c > '~'; }, '?');
  return decoder.from.empty() ? std::nullopt : std::optional(std::move(decoder));
}

std::vector<V4l2Decoder> list_v4l2_decoders(const std::filesystem::path& devices) {
  std::vector<V4l2Decoder> decoders;
  for (const auto& node : video_nodes(devices))
    if (const auto device = open_video_device(node))
      if (auto decoder = decoder_of(**device)) decoders.push_back(std::move(*decoder));
  return decoders;
}

}  // namespace kasumi
