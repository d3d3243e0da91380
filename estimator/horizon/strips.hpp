// A scene's sky from the top down to its lowest part, strip by strip across the view.
#pragma once

#include <array>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {

struct HorizonPixels {
  HorizonPixels(const Camera& camera, const Image<Rgb8>& picture, const Image<std::uint8_t>& sky);

  const Camera& camera;
  const Image<Rgb8>& picture;
  const Image<std::uint8_t>& sky;  // 255 where sky
  std::array<glm::dvec3, 256> light_of_level;

  glm::dvec3 light_at(int x, int y) const;
  glm::dvec3 log_step_at(int x, int y) const;  // one step of the encoded values, as ln light
  bool clipped_at(int x, int y) const;         // in any channel
};

// Not 0 where a pixel is more than half a degree below the horizon: never sky (segment_sky).
Image<std::uint8_t> below_horizon(const Camera& camera);

// Pixels of one strip near its lowest sky: columns x0..x1-1, rows top..edge.
struct HorizonStrip {
  int x0 = 0, x1 = 0;
  int top = 0;         // upper end of the rows in which a faded hill may hide
  int edge = 0;        // lowest row that is mostly sky, with faded hills counted as sky
  int first_drop = 0;  // going down, the last row above the first sharp drop of light; edge when there is none
  int certain = 0;     // no hill down to this row, but clouds are possible
};

// Shares of the picture's height.
constexpr double kHorizonBand = 0.025;    // the horizon region
constexpr double kHorizonMargin = 0.006;  // above a silhouette, whose pixels are mixed

// Strips with sky, from the left.
std::vector<HorizonStrip> sky_strips(const HorizonPixels& scene, int strips);

// Light of the clear sky above the land, one column per strip: the lowest cells that lie on one smooth surface of
// light, unlike clouds and hills. Empty where too little of the sky is clear to be sure.
std::vector<HorizonColumn> clear_sky(const HorizonPixels& scene, const std::vector<HorizonStrip>& strips);

// Light of the lowest sky above the first drop of light, without outliers, smoothed over azimuth. For clipped, overcast
// and cloudy skies; one column for each strip with enough sky.
struct SmoothHorizon {
  std::vector<HorizonColumn> columns;
  bool clipped = false;  // most of them
};
SmoothHorizon lowest_sky(const HorizonPixels& scene, const std::vector<HorizonStrip>& strips);

}  // namespace kasumi
