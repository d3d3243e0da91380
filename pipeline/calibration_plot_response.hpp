// What `calibrate response` did, as a picture for a person; and the merged stack as a file.
#pragma once

#include <string>

#include "base/picture.hpp"
#include "calib/response_fit.hpp"

namespace kasumi {

// Left: light over value, both in stops, the three channels' curves and the pixels of the stack. Right: the same
// linear.
Image<Rgb8> plot_response(const ResponseFit& fit, const StackSamples& samples, const std::string& title);

}  // namespace kasumi
