// `kasumi calibrate sky` for pictures of a camera of which nothing is known but where it stands.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "calib/mask/image_circle.hpp"
#include "pipeline/site/files/picture_times.hpp"

namespace kasumi {

struct OrientationSeries {
  std::vector<std::string> pictures;  // folder, list, pattern or files
  PictureTimes times;
  Site site;
  std::optional<ImageCircle> circle;  // empty: found
  double level_sigma_deg = 5.0;
  std::string serial, out;
};

// Circle, projection, mounting, mirror, tone curve, rim loss and mask, each with its sigma and what it rests on, into
// the calibration file `out`, with drawings beside it. Returns exit code 0. Errors: bad_input, io.
Result<int> calibrate_sky_series(const OrientationSeries& series);

}  // namespace kasumi
