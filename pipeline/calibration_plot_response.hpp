// What `calibrate response` did, as a picture for a person; and the merged stack as a file.
#pragma once

#include <filesystem>
#include <string>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/response_fit.hpp"

namespace kasumi {

// Left: light over value, both in stops, the three channels' curves and the pixels of the stack. Right: the same
// linear.
Image<Rgb8> plot_response(const ResponseFit& fit, const StackSamples& samples, const std::string& title);

// A TIFF of 32-bit floating point, R G B. Errors: io, bad_input (a name that is not .tif or .tiff).
Result<> write_light(const std::filesystem::path& path, const Image<glm::vec3>& light);

}  // namespace kasumi
