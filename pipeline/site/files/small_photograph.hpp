// A photograph at an eighth of its size, for a first look.
#pragma once

#include <filesystem>
#include <optional>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "pipeline/site/files/taken_at.hpp"

namespace kasumi {

constexpr int kSmallPhotographShrink = 8;  // pixels, either way, that make one
struct SmallPhotograph {
  Image<glm::vec3> encoded;   // as read_photograph() has it: means
  int width = 0, height = 0;  // of the photograph
  TakenAt taken;
};

// Empty: cannot be read, is no whole JPEG as cameras write it, is turned, or has a colour profile. What it then is,
// read_photograph() says.
std::optional<SmallPhotograph> read_small_photograph(const std::filesystem::path& path);

}  // namespace kasumi
