// How far landmarks at known distance stand out from the light from infinity: what haze takes from them is their
// contrast.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {

struct PictureBox {
  int x = 0, y = 0, width = 0, height = 0;
};

// Contrast, here and below: (light it stands against - light of the surface) / light from infinity. Against the sky it
// is 1 - L / Linf: .95 of a wood in the shade, .7 of a bright wall, negative where the sun on snow outshines the
// horizon.
struct ContrastLandmark {
  std::string name;
  double distance_m = 0.0;
  double rise_m = 0.0;                // of the surface above the camera
  PictureBox surface;                 // pixels that show nothing else
  std::optional<PictureBox> against;  // a neighbouring surface about as far away; nothing: the sky
  std::optional<PictureBox> sky;  // sky low beside it, the light from infinity; nothing: the picture's horizon there
  // What is known of its contrast without any air in front, before the first picture: mean and standard deviation.
  // 1 - L / Linf of woods and grey masonry (reflectance .04-.2) under a horizon about as bright as a white wall.
  double contrast = 0.85;
  double contrast_sigma = 0.1;
};

// The noise model, docs/physics.md 11. Beyond what is stated here nothing enters a reading's sigma.
struct ContrastNoise {
  double pixel = 2.0 / 255.0;   // of one pixel, encoded; of neighbours a quarter counts as independent
  double flare = 0.005;         // light strayed in lens and camera, of the sky's
  double clipped_sky = 0.2;     // what a clipped sky may be brighter than it shows
  double clipped_share = 0.05;  // of its pixels, from which on it counts as clipped
};

struct ContrastReading {
  bool usable = false;
  std::string reason;  // why not; or what is doubtful ("the sky beside it is clipped")
  glm::dvec3 contrast{0};
  glm::dvec3 sigma{0};  // of reading it in this picture, not of how the surface is lit
};

// One reading for each landmark, in their order. `encoded`: the camera's numbers, 0..1, its size. `horizon`: of the
// same picture; only asked for landmarks without a sky box. A landmark hidden by the camera's mask, outside the picture
// or brighter than full scale is not usable.
std::vector<ContrastReading> read_contrasts(const Camera& camera, const Image<glm::vec3>& encoded,
                                            const std::vector<ContrastLandmark>& landmarks,
                                            const HorizonLight& horizon = {}, const ContrastNoise& noise = {});

// Optical length of the path to it, in metres of air as the camera stands in (haze thins with altitude, physics 4).
double haze_path_m(const ContrastLandmark& landmark, double camera_altitude_m);

}  // namespace kasumi
