// The light of the horizon sky, measured: what haze at infinity looks like today, through the scene camera's own
// exposure (M Sect 4; physics 5).
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
  bool visible = false;  // enough sky to measure a horizon
  std::string reason;    // for a person, when not visible: "no sky: nothing bright and textureless in the upper part"
  Image<std::uint8_t> sky;    // picture size, 255 where sky, else 0
  double sky_fraction = 0.0;  // of the picture
};
// Watershed grown from bright or blue textureless areas of the upper part against textured or dark areas and the bottom
// (M Sect 4). The top of the picture must be up within some 20 deg. `never_sky`: empty, or picture size with non-zero
// where there cannot be sky, such as below the horizon.
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
  std::string reason;                  // for a person: why none, or what had to be assumed
  std::vector<HorizonColumn> columns;  // by azimuth, clockwise from the view's left edge; empty when none
  bool usable() const { return !columns.empty(); }
};
std::string_view name_of(HorizonLight::Source source);
// The column at an azimuth, interpolated between its neighbours; beyond the measured span, the nearest one. The horizon
// must be usable.
HorizonColumn column_at(const HorizonLight& horizon, Radians azimuth);

// Scene camera's horizon sky at up to `columns` azimuths across the view: the lowest clear sky of each, above hills
// that fade into it and between clouds; where too little is clear to be sure (`reason` then says so) the lowest visible
// sky, outliers left out, smooth over azimuth. Where the sky is clipped the clipped value is taken, with a low quality:
// it is what the picture shows. Says in `reason` why there is none.
HorizonLight measure_horizon(const Camera& scene, const PictureView& picture, int columns = 16);

// When the scene shows no sky: the sky camera's ring at zenith angles 75-85 deg around the view's azimuths gives the
// colour and the distribution over azimuth, taken to the scene camera's channels through XYZ. What it cannot give is
// the level, as the two cameras' exposures are unknown to each other: the ring's mean is set as bright as the brightest
// distant things in the scene. Haze in front of things is at most as bright as haze at infinity, so that level is a
// lower bound; `reason` says that it was assumed, and quality is low.
HorizonLight horizon_from_sky_camera(const Camera& sky, const PictureView& sky_picture, const Camera& scene,
                                     const PictureView& scene_picture, int columns = 16);

// When no camera shows sky: the colours of the model's sky above the horizon (`sky_xyz`: CIE XYZ of any scale at a
// direction), as bright as the brightest distant things in the scene, which is a lower bound; quality is low.
HorizonLight horizon_from_model(const std::function<glm::dvec3(const Direction&)>& sky_xyz, const Camera& scene,
                                const PictureView& scene_picture, int columns = 16);

// Temporal smoothing: weight 0 keeps the previous, 1 takes the current. An unusable one gives way to the other.
HorizonLight blend(const HorizonLight& previous, const HorizonLight& current, double weight);

}  // namespace kasumi
