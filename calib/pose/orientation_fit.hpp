// Orientation and principal point of the sky camera, from the sun's positions in its pictures.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>

#include "base/geometry.hpp"
#include "base/result.hpp"
#include "calib/lens/lens_description.hpp"
#include "calib/mask/image_circle.hpp"

namespace kasumi {

// The sun once: where it stood (ephemeris, refraction included) and where the picture shows it.
struct SunSight {
  Direction sun{0, 0, 1};
  glm::dvec2 pixel{};
  double relative_sigma = 1.0;  // of this place, over the usual one's
  // A sky that is brighter towards the horizon lowers the middle of a bright spot, by SkySag times this, and makes its
  // height less certain than its azimuth: sigma across the vertical over that along it.
  double lowered = 0.0;
  double across = 1.0;
};

// Prior knowledge. One standard deviation each.
struct OrientationPrior {
  LensDescription lens;
  glm::dvec2 centre_sigma_px{3.0};          // of the lens's centre: about 0.5 for a found image circle
  double scale_sigma = 0.03;                // of its focal length, relative: a data sheet's; 1e-3 for a calibrated lens
  glm::dmat3 to_world{1.0};                 // as mounted; only its optical axis is used, never the azimuth
  Radians level_sigma = from_degrees(3.0);  // of that axis
  double least_sigma_px = 0.05;             // no centroid is better, however well a few happen to agree
  Radians sag_sigma{0.0};                   // of how far a sight with .lowered 1 is lowered; 0: none is
  std::array<double, 2> odd_sigma{};        // of k1 and k2 of OpenCV's fisheye model; 0: as the lens has them
};

struct OrientationFit {
  glm::dmat3 to_world{1.0};
  LensDescription lens;                    // moved and scaled
  double scale = 1.0;                      // focal length over the prior's
  std::vector<bool> used;                  // one for each sight; false: not where the others say the sun was
  Radians sag{};                           // of the sights, where OrientationPrior lets them
  std::vector<glm::dvec2> residuals_px{};  // seen minus modelled, of all sights
  std::vector<double> misfits_px{};        // their lengths in units of relative_sigma and across
  double rms_px = 0.0;                     // of those used
  // One standard deviation each, priors included.
  struct Sigma {
    Radians azimuth, tilt_east, tilt_north;
    glm::dvec2 centre_px{};
    double scale = 0.0;
    std::array<double, 2> odd{};
  } sigma;
  std::vector<std::string> undetermined;  // for people: what the sights leave undetermined
};

// A shift of the lens's centre and a tilt of the camera look nearly the same: the axis is found no better than
// centre_sigma_px over the focal length, though pixels near the sun's path get their true direction all the same.
// With the sun at one place (within 3 deg) only the turn about the vertical is found, all else stays as the prior has
// it. Otherwise: the two sights that most others agree with (so that the azimuth needs no start and reflections do no
// harm), then all that agree, by Ceres. Deterministic. Errors (bad_input): no sights; no two that agree.
Result<OrientationFit> fit_orientation(std::span<const SunSight> sights, const OrientationPrior& prior);

}  // namespace kasumi
