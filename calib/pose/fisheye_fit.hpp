// An unknown sky camera from the suns in its pictures: its projection, how it stands, and whether its pictures are
// mirrored. Nothing is known beforehand but that it looks up and where its image circle is.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "calib/pose/orientation_fit.hpp"

namespace kasumi {

struct FisheyeFit {
  OrientationFit orientation;   // with the lens
  std::string_view projection;  // "equidistant", "equisolid", "stereographic", "orthographic", "two odd terms"
  bool mirrored = false;
  bool mirror_known = false;  // else it was supposed that they are not
};

struct FisheyePrior {
  ImageCircle circle;                      // at 90 deg off the axis, or near
  Radians edge_sigma = from_degrees(4.0);  // of what the circle is off the axis
  Radians level_sigma = from_degrees(5.0);
  double sun_sigma_px = 1.0;  // of a sun's height; its azimuth is known better, see SunSight
  Radians sag_sigma = from_degrees(0.4);
};

// Every projection, plain and mirrored, is tried; the simplest that explains the suns is taken (Schwarz' criterion).
// With the sun at one place only the azimuth is found, under an equidistant lens. Errors: those of fit_orientation.
Result<FisheyeFit> fit_fisheye(std::span<const SunSight> sights, const FisheyePrior& prior);

// The lens for the picture as it is stored; it was fitted to one whose columns were stretched to square pixels.
LensDescription in_stored_pixels(const LensDescription& lens, double pixel_aspect);

}  // namespace kasumi
