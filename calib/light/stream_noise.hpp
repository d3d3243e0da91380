// The sensor's noise as it was before sharpening and JPEG changed it, from pictures of a still scene.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "base/image.hpp"
#include "base/jpeg_steps.hpp"
#include "base/picture.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

// What the sensor's numbers went through.
struct StreamProcessing {
  glm::dvec3 white_balance{1.0};
  double sharpening = 0.0;                // as DrawnEdge's
  std::shared_ptr<const JpegSteps> jpeg;  // null: 8 bits, no JPEG
};

struct StreamNoise {
  double full_scale_electrons = 0.0;  // at the pictures' gain
  double read_electrons = 0.0;
  double misfit = 0.0;  // rms of ln(variance seen / variance of the model) over the levels of brightness
};

// The variance of Y from picture to picture, median over blocks of 8 x 8, at up to eight brightnesses, is what noise of
// E and r electrons leaves of itself when it goes the same way (simulated: JPEG's rounding has no closed form). At
// least 3 pictures of one size; whatever moves is outvoted. Empty: no noise above 8 bits.
std::optional<StreamNoise> fit_stream_noise(std::span<const Image<Rgb8>> pictures, const Response& response,
                                            const StreamProcessing& processing);

}  // namespace kasumi
