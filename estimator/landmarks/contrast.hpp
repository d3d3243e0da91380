// How far landmarks at known distance stand out from the light from infinity. Haze reduces this contrast.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {

struct LandmarkBox {
  int x = 0, y = 0, width = 0, height = 0;
};

// A strip of pixels below a line from left to right: a hillside under its ridge.
struct RidgeStrip {
  std::vector<glm::dvec2> line;  // pixels; at least two points
  double height_px = 0.0;
  // The ridge's own pixel shows sky, too, and does not belong to it.
  bool contains(int x, int y) const;
  LandmarkBox bounds() const;
};

// Contrast, here and below: (light behind it - light of the surface) / light from infinity. Against the sky it is 1 - L
// / Linf: .95 for a wood in the shade, .7 for a bright wall, negative where sunlit snow outshines the horizon.
struct ContrastLandmark {
  std::string name;
  double distance_m = 0.0;
  double rise_m = 0.0;                 // of the surface above the camera
  LandmarkBox surface;                 // pixels that show nothing else
  std::optional<RidgeStrip> ridge;     // of these only the ones in this strip; nothing: all
  std::optional<LandmarkBox> against;  // a neighbouring surface about as far away; nothing: the sky
  std::optional<LandmarkBox> sky;  // low sky next to it, the light from infinity; nothing: the picture's horizon there
  // Prior of its contrast without any air in front, before the first picture: mean and standard deviation. 1 - L / Linf
  // of facades in the shade is .92 to 1.0, of trees .98 (measured on towers, docs/accuracy.md).
  double contrast = 0.94;
  double contrast_sigma = 0.06;
  bool contrast_stated = false;  // for this surface; else the sun may lie on it as well
  // The light from infinity behind it may differ from the sky that it is compared with by this share.
  double infinity_sigma = 0.01;
  std::optional<Radians> faces{};  // the azimuth to which a facade looks
};

// The noise model, docs/physics.md 11. A reading's sigma has no other contributions.
struct ContrastNoise {
  double pixel = 2.0 / 255.0;   // of one pixel, encoded; of neighbouring pixels a quarter counts as independent
  double flare = 0.005;         // stray light in lens and camera, as a share of the sky's
  double clipped_sky = 0.2;     // a clipped sky may be brighter than shown by this much
  double clipped_share = 0.05;  // share of its pixels from which on a box counts as clipped
};

struct ContrastReading {
  bool usable = false;
  std::string reason;  // why it is not usable, or what is doubtful ("the sky next to it is clipped")
  glm::dvec3 contrast{0};
  glm::dvec3 sigma{0};  // of the measurement in this picture, not of the surface's illumination
  bool lit = false;     // in the sun: brighter than the law has it, so that its contrast is a lower bound
};

// One reading for each landmark, in order. `encoded`: the camera's values, 0..1, at its size. `horizon`: of the same
// picture; only used for landmarks without a sky box. A landmark outside the picture or brighter than full scale is not
// usable. The camera's mask is not asked: it says what stands before the building, and a near wood may be a landmark.
std::vector<ContrastReading> read_contrasts(const Camera& camera, const Image<glm::vec3>& encoded,
                                            const std::vector<ContrastLandmark>& landmarks,
                                            const HorizonLight& horizon = {}, const ContrastNoise& noise = {});

// Marks those that the sun shines on. Facades without a known direction are not marked.
void mark_lit(const std::vector<ContrastLandmark>& landmarks, const Direction& sun,
              std::vector<ContrastReading>& readings);
// A dark surface that is brighter than the sky beside it stands before a sky that is no light from infinity (a rain
// cloud behind a sunlit tower): those are made unusable, and where they are many all.
void refuse_dark_skies(const std::vector<ContrastLandmark>& landmarks, std::vector<ContrastReading>& readings);
// How far the light from infinity at a landmark may differ from the sky beside it, which is so many pixels away.
double infinity_sigma(const ContrastLandmark& landmark, int picture_width);

// Optical length of the path to it, in metres of air at the camera's altitude (haze thins with altitude, physics 4).
double haze_path_m(const ContrastLandmark& landmark, double camera_altitude_m);

}  // namespace kasumi
