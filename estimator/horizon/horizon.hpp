// The measured light of the horizon sky: what haze at infinity looks like today, at the scene camera's own exposure (M
// Sect 4; physics 5).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"

namespace kasumi {

// Which pixels of a scene show sky.
struct SkySegmentation {
  bool visible = false;     // enough sky to measure a horizon
  std::string reason;       // for people, when not visible: "no sky: nothing bright and textureless in the upper part"
  Image<std::uint8_t> sky;  // picture size, 255 where sky, else 0
  double sky_fraction = 0.0;  // of the picture
};
// Watershed from two kinds of seeds: bright or blue textureless areas of the upper part, and textured or dark areas and
// the bottom (M Sect 4). The top of the picture must be up within some 20 deg. `never_sky`: empty, or the picture's
// size with non-zero values where there cannot be sky, such as below the horizon.
SkySegmentation segment_sky(const Image<Rgb8>& picture, const Image<std::uint8_t>& never_sky = {});

// Horizon light at one azimuth.
struct HorizonColumn {
  Radians azimuth;
  Radians zenith;        // theta' at which it was measured
  glm::dvec3 light{0};   // linear, the scene camera's channels and scale (Camera::light_at)
  double quality = 0.0;  // 0..1: share of the column's horizon pixels that agreed
};

struct HorizonLight {
  enum class Source { none, scene_camera, sky_camera, model };
  Source source = Source::none;
  std::string reason;                  // for people: why there is none, or what had to be assumed
  std::vector<HorizonColumn> columns;  // by azimuth, clockwise from the view's left edge; empty when none
  bool usable() const { return !columns.empty(); }
};
std::string_view name_of(HorizonLight::Source source);
// The column at an azimuth, interpolated between its neighbours; beyond the measured span, the nearest one. The horizon
// must be usable.
HorizonColumn column_at(const HorizonLight& horizon, Radians azimuth);

// The scene camera's horizon sky at up to `columns` azimuths across the view: the lowest clear sky of each, above hills
// that fade into it and between clouds. Where too little is clear (`reason` then says so), the lowest visible sky,
// without outliers and smoothed over azimuth. A clipped sky gives the clipped value with a low quality, since that is
// what the picture shows. When there is none, `reason` says why.
HorizonLight measure_horizon(const Camera& scene, const PictureView& picture, int columns = 16);

// For scenes that show no sky: the sky camera's ring at zenith angles 75-85 deg around the view's azimuths gives the
// colour and the distribution over azimuth, converted to the scene camera's channels through XYZ. It cannot give the
// level, because the two cameras' relative exposure is unknown: the ring's mean is set as bright as the brightest
// distant objects in the scene. Haze in front of an object is at most as bright as haze at infinity, so that level is a
// lower bound; `reason` says that it was assumed, and quality is low.
HorizonLight horizon_from_sky_camera(const Camera& sky, const PictureView& sky_picture, const Camera& scene,
                                     const PictureView& scene_picture, int columns = 16);

// When no camera shows sky: the colours of the model's sky above the horizon (`sky_xyz`: CIE XYZ in any scale for a
// direction), as bright as the brightest distant objects in the scene, which is a lower bound; quality is low.
HorizonLight horizon_from_model(const std::function<glm::dvec3(const Direction&)>& sky_xyz, const Camera& scene,
                                const PictureView& scene_picture, int columns = 16);

// Temporal smoothing: weight 0 keeps the previous, 1 takes the current. If one is unusable, the other is taken.
HorizonLight blend(const HorizonLight& previous, const HorizonLight& current, double weight);

}  // namespace kasumi
