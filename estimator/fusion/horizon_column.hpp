// The column's aerosol by the low sky in the scene camera's picture: its gradient in elevation, and its colour.
#pragma once

#include <optional>
#include <string>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/fusion/air_observation.hpp"
#include "estimator/sky/site_sky.hpp"
#include "estimator/sky_fit/sky_fit.hpp"

namespace kasumi {

struct HorizonColumnFit {
  std::optional<ColumnReading> reading;
  std::string reason;  // for people: why there is none
  SkyFit fit;          // what the models make of it, before what a low sky cannot know is added
  int patches = 0;
};

// `sky`: which models, the site's altitude, what is given. The sun must be up.
HorizonColumnFit column_by_horizon(const Camera& scene, const PictureView& picture, const SunDirection& sun,
                                   const ModelToFit& sky);

}  // namespace kasumi
