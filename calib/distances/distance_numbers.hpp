// The numbers of a file of distances as they stand there, whatever they mean.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "base/result.hpp"

namespace kasumi {

struct DistanceNumbers {
  cv::Mat values;          // CV_16UC1 or CV_32FC1
  bool are_whole = false;  // steps, of 16 bits
  // What writers put where they have no distance, or the background; NaN: nothing of the kind.
  double saturated = std::numeric_limits<double>::quiet_NaN(), background = saturated;
  std::vector<std::string> remarks;  // "channel Z of R, G, B, Z"
  std::string other_channels;        // of an EXR, that were not taken
};

// By content. `channel` of an EXR: empty: the first of Z, *.Z, V, *.V, depth, Y, and R where G and B are equal or
// absent. Errors (bad_input): no such file, channel or number of bits; colours.
Result<DistanceNumbers> read_distance_numbers(const std::filesystem::path& path, const std::string& channel);

}  // namespace kasumi
