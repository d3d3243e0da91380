// ICC profiles, by lcms2. Part of the module: no program loads the library before it meets such a picture.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <opencv2/core.hpp>

namespace kasumi {

// From the profile's colours to sRGB, relative to white. `picture`: R G B, R G B A or grey, of 8 or 16 bits; it becomes
// floats of 0..1, grey becomes R G B, alpha stays. Unchanged where the profile is sRGB's to half a step of 255, and
// where it is of floats, which are light. Returns what is wrong; empty: nothing.
std::string profile_to_srgb(cv::Mat& picture, std::span<const std::uint8_t> profile);

// Of these primaries (x, y of the CIE 1931), white of D65 and the curve of sRGB. Empty: none can be made.
std::vector<std::uint8_t> profile_of_primaries(glm::vec2 red, glm::vec2 green, glm::vec2 blue);
std::vector<std::uint8_t> profile_of_srgb();  // empty: none can be made

}  // namespace kasumi
