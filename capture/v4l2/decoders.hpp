// Decoders of compressed video in hardware, as V4L2's memory-to-memory devices.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/v4l2/video_device.hpp"

namespace kasumi {

struct V4l2Decoder {
  std::string driver;             // "bcm2835-codec"
  std::vector<std::string> from;  // compressed: "H264", "MJPG"; "S264": one picture at a time, parsed by the program
  std::vector<std::string> to;    // as the driver lists them before it has seen a stream
};

// Empty: the device decodes nothing (a camera, an encoder, a scaler, or an unanswered question).
std::optional<V4l2Decoder> decoder_of(VideoDevice& device);
// Those that this account may open, by number. Opens each briefly.
std::vector<V4l2Decoder> list_v4l2_decoders(const std::filesystem::path& devices = "/dev");

}  // namespace kasumi
