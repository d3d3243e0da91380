// Whether a coarse picture already shows that no air is to be found in the sky.
#pragma once

#include <optional>
#include <utility>

#include "estimator/turbidity/sky_verdict.hpp"

namespace kasumi {

struct ClosedSky {
  Refusal refusal;
  bool sun_may_show = false;  // then it holds where the whole picture does not show it either
};

// Keeps what depends on the camera alone. Not thread-safe.
class FirstLook {
 public:
  explicit FirstLook(Camera camera) : camera_(std::move(camera)) {}
  // What SkyObserver::observe() would refuse the whole picture for, before it fits anything: a covered lens, or a sky that
  // is grey all over. Empty: one must look closer, also where that is likely but near to its limits.
  // `coarse`: elements are means of pixels, some 60 to 160 across.
  std::optional<ClosedSky> refuse(const SkyPicture& coarse, const SunDirection& sun, const EstimateParameters& options);
  // As ColourStatistics::sun_seen has it.
  bool shows_sun(const SkyPicture& whole, const SunDirection& sun);
  const Camera& camera() const { return camera_; }

 private:
  Camera camera_;
  std::optional<ElementGeometry> geometry_, whole_geometry_;
};

}  // namespace kasumi
