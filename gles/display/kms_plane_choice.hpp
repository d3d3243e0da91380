// Chooses the planes that carry the camera's picture and the building over it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "gles/display/kms_device.hpp"

namespace kasumi {

// The camera's plane lies below.
struct KmsPlanePair {
  std::uint32_t camera = 0;
  std::uint32_t building = 0;
  std::optional<std::uint64_t> camera_zpos{};  // to be set; empty: as it is
  std::optional<std::uint64_t> building_zpos{};
  friend bool operator==(const KmsPlanePair&, const KmsPlanePair&) = default;
};

// Pairs of which one is `primary`, which drivers want on: those that leave the camera's picture on it come first. Only
// the driver knows which of them work together. `encoding`: empty: not YUV.
// Error: unsupported, with what is missing.
Result<std::vector<KmsPlanePair>> choose_planes(const std::vector<KmsPlane>& planes, std::uint32_t primary,
                                                std::uint32_t camera_format, std::optional<YuvEncoding> encoding);

}  // namespace kasumi
