// The scene camera's pose from landmarks of known position.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>

#include "base/geometry.hpp"
#include "base/result.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

// One landmark: where it is, and where the picture shows it. The sun is one too, very far away.
struct LandmarkSight {
  std::string name;
  glm::dvec3 place_m{};  // east, north, up from the camera, as it appears: curvature and refraction are in it
  glm::dvec2 pixel{};
  double sigma_px = 1.0;       // of that pixel, each coordinate; standard deviation
  double place_sigma_m = 0.0;  // of its place, across the line of sight
};

// A point on a level line that runs all around, as the sea's horizon does.
struct HorizonSight {
  glm::dvec2 pixel{};
  Radians dip{};  // how far it lies below the horizontal, as it appears
  double sigma_px = 1.0;
};

// Prior knowledge. One standard deviation each.
struct ScenePrior {
  int width = 0;
  int height = 0;
  LensDescription lens;
  double scale_sigma = 0.0;                 // of its focal length, relative; 0: it is held
  double position_sigma_m = 0.0;            // of the camera's own place, each axis; 0: it is held
  Radians level_sigma = from_degrees(5.0);  // of the camera's roll, about 0
};

struct ScenePose {
  glm::dmat3 to_world{1.0};
  LensDescription lens;                      // scaled
  double scale = 1.0;                        // focal length over the prior's
  glm::dvec3 position_m{0.0};                // estimated minus stated position of the camera
  std::vector<bool> used;                    // one for each landmark; false: not where the others say it is
  std::vector<glm::dvec2> residuals_px;      // seen minus modelled, of all landmarks
  std::vector<bool> horizon_used;            // the same of the horizon's points
  std::vector<double> horizon_residuals_px;  // across the line, positive: seen above it
  double rms_px = 0.0;                       // of the landmarks used
  double misfit = 0.0;  // residuals over what their sigmas let expect; about 1 when those are honest
  // One standard deviation each, priors included, and larger as the misfit is.
  struct Sigma {
    Radians heading, pitch, roll;
    Radians anywhere;  // of the direction that any pixel of the picture sees, at its worst
    double scale = 0.0;
    glm::dvec3 position_m{};
  } sigma;
  std::vector<std::string> undetermined;  // for people: what the landmarks leave undetermined or unchecked
};

// One landmark is enough with two points of the horizon, which level the camera. Every pair of landmarks is tried as a
// start, so none is needed and a wrong landmark does no harm; then least squares
// (Ceres) over all that agree, in which whatever the rest contradicts (studentised residual beyond the 99.9 % bound,
// Baarda's data snooping) is dropped, the worst first. Deterministic.
// Errors (bad_input): fewer landmarks than that; no more than half of them agree.
Result<ScenePose> pose_scene(std::span<const LandmarkSight> landmarks, std::span<const HorizonSight> horizon,
                             const ScenePrior& prior);

// Dip of the horizon for an observer `height_m` above a level surface; `refraction`: coefficient of refraction.
Radians dip_of_horizon(double height_m, double refraction);

}  // namespace kasumi
