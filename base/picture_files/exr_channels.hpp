// Channels of OpenEXR files by name, which OpenCV does not give: it knows R, G, B and Y. Part of the module.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace kasumi {

// As the file orders them; of several parts and one name the first. Empty: not an EXR, or damaged.
std::vector<std::string> names_of_exr_channels(std::span<const std::uint8_t> file);
// CV_32F; empty: no such channel, damaged, or larger than a photograph may be.
cv::Mat read_exr_channel(std::span<const std::uint8_t> file, const std::string& name);

}  // namespace kasumi
