// Input of the calibration check: some pictures of both cameras, kept in memory only until it is done.
#pragma once

#include <vector>

#include "calib/mask/dome_spots.hpp"
#include "calib/pose/view_turn.hpp"
#include "capture/frame.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

constexpr int kMostCheckFrames = 15;   // of each camera: the median removes what is visible in fewer than half of them
constexpr int kFewestCheckFrames = 3;  // a median of fewer does not remove what passes
constexpr int kCheckSide_px = 480;     // longest side of the compared views
constexpr int kDomeSide_px = 160;      // shades of a dirty dome are smooth: a third of the views' side shows them

// A grey, encoded picture of the camera's own size.
using GreyImage = Image<std::uint8_t>;
GreyImage median_of(const std::vector<GreyImage>& pictures);
// The median of three or more values; empty for fewer.
std::optional<double> median_if_enough(std::vector<double> values);
int shrink_factor(const Camera& camera);
// Shrinks by that factor, averaging light; incomplete blocks at the right and bottom are dropped.
ShrunkView shrunk_view(const GreyImage& picture, const Camera& camera, Image<std::uint8_t> usable);
Image<float> light_of(const GreyImage& picture, const Camera& camera);
// Where the sky camera's picture shows static things: around the obstructions in its mask, or without a mask low above
// the horizon. One element per block of `factor` pixels.
Image<std::uint8_t> still_part_of_sky(const Camera& sky, int factor);

// Of a picture of the dome so large: open sky, away from the horizon, obstructions and all positions of the sun.
Image<std::uint8_t> open_sky(const Camera& sky, int width, int height, const std::vector<Direction>& suns);

// One observation of the sun: its ephemeris, and its direction in the picture by the calibration.
struct SunObservation {
  Direction ephemeris{0, 0, 1};
  Direction picture{0, 0, 1};
};

class DriftFrames {
 public:
  explicit DriftFrames(const Installation& installation);
  // Pictures of another size than the camera's are ignored. `utc`: for the sun's position, if the time is known.
  void add_scene(const PictureView& view);
  void add_sky(const PictureView& view, const FrameMetadata& metadata, std::optional<Utc> utc);

  const std::vector<GreyImage>& scene() const { return scene_; }
  const std::vector<GreyImage>& sky() const { return sky_; }
  const std::vector<DomeFrame>& dome() const { return dome_; }
  const std::vector<SunObservation>& suns() const { return suns_; }
  const std::vector<Direction>& sun_places() const { return sun_places_; }
  // ln of the clear sky's light per exposure, relative to the sky model: constant as long as lens and sensor are.
  const std::vector<double>& levels() const { return levels_; }
  const std::vector<double>& turbidities() const { return turbidities_; }

 private:
  Camera scene_camera_;
  Site site_;
  SkyObserver observer_;
  std::vector<GreyImage> scene_, sky_;
  std::vector<DomeFrame> dome_;
  std::vector<SunObservation> suns_;
  std::vector<Direction> sun_places_;
  std::vector<double> levels_, turbidities_;
};

}  // namespace kasumi
