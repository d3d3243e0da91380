// The kiosk's picture at any time and under any air, before a camera is mounted: the building as it would be drawn, over
// sky and land that are drawn, too.
#pragma once

#include <memory>
#include <string>

#include "base/clock.hpp"
#include "base/geometry.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "estimator/atmosphere.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

// The instant at which the wall clock of that zone shows that time; without a zone, the clock that follows the mean sun.
Utc utc_of(std::chrono::local_time<Duration> wall, const std::string& time_zone, double longitude_deg);

// Brightness of a camera's picture, 1 by day. From a sun 6 degrees up to 3 degrees down daylight falls to a hundredth; the
// exposure follows most of it and lets the picture fall to a fifth, so that evening looks like evening. Below, it follows
// no further, and the light falls to a tenth with each 2.7 degrees, as twilight does.
double brightness_under(const Direction& sun);

// The same kiosk with a scene camera of fewer pixels, at most so many wide: a sheet's cells are small. Only a pinhole camera
// can be made smaller.
Installation with_small_scene(Installation kiosk, int most_width);

// One model under one air. Belongs to the thread of its GL context.
class RehearsedView {
 public:
  // All must outlive it. Errors: bad_input (the model), device.
  static Result<RehearsedView> create(GlContext& context, const Installation& installation, const Model& model,
                                      Turbidity air);
  RehearsedView(RehearsedView&&) noexcept;
  RehearsedView& operator=(RehearsedView&&) noexcept;
  ~RehearsedView();
  // Under a clear sky. Errors: device.
  Result<Image<Rgb8>> draw(Utc utc);

 private:
  struct Parts;
  explicit RehearsedView(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace kasumi
