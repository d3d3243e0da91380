// What the check of the calibration looks at: some pictures of both cameras, kept in memory and given up afterwards.
#pragma once

#include <vector>

#include "calib/mask/dome_spots.hpp"
#include "calib/pose/view_turn.hpp"
#include "capture/frame.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/config/installation.hpp"

namespace kasumi {

constexpr int kMostCheckFrames = 15;  // of each camera: a median forgets what stays less than half of the time
constexpr int kFewestCheckFrames = 3;
constexpr int kCheckSide_px = 480;  // longest side of the pictures that are compared, and of the reference's
constexpr int kDomeSide_px = 160;

// A camera's view without what moves: grey, encoded, of the camera's own size.
using GreyPicture = Image<std::uint8_t>;
GreyPicture median_of(const std::vector<GreyPicture>& pictures);
// Of three or more; of fewer nothing.
std::optional<double> middle_of(std::vector<double> values);
int shrink_factor(const Camera& camera);
// By that factor, each element the mean light of its pixels; what is left over at the right and below is dropped.
GreyPicture shrunk(const GreyPicture& picture, const Camera& camera);
ShrunkView shrunk_view(const GreyPicture& small, const Camera& camera);
Image<float> light_of(const GreyPicture& picture, const Camera& camera);
// Where what stands still is to be looked for in the sky camera's picture: about its obstructions (its mask), else low
// above the horizon. Of elements of `factor` pixels.
Image<std::uint8_t> still_part_of_sky(const Camera& sky, int factor);

// The sun once: where it stood, and where the calibration says that the picture shows it.
struct SunSeen {
  Direction ephemeris{0, 0, 1};
  Direction picture{0, 0, 1};
};

class DriftFrames {
 public:
  explicit DriftFrames(const Installation& installation);
  // Pictures of another size than the camera's are not kept. `utc`: where the time is known, for the sun's place.
  void add_scene(const PictureView& view);
  void add_sky(const PictureView& view, const FrameMetadata& metadata, std::optional<Utc> utc);

  const std::vector<GreyPicture>& scene() const { return scene_; }
  const std::vector<GreyPicture>& sky() const { return sky_; }
  const std::vector<DomeFrame>& dome() const { return dome_; }
  const std::vector<SunSeen>& suns() const { return suns_; }
  const std::vector<Direction>& sun_places() const { return sun_places_; }
  // ln of the clear sky's light per exposure, over what the sky's model has: constant as long as lens and sensor are.
  const std::vector<double>& levels() const { return levels_; }
  const std::vector<double>& turbidities() const { return turbidities_; }

 private:
  Camera scene_camera_;
  Site site_;
  SkyObserver observer_;
  std::vector<GreyPicture> scene_, sky_;
  std::vector<DomeFrame> dome_;
  std::vector<SunSeen> suns_;
  std::vector<Direction> sun_places_;
  std::vector<double> levels_, turbidities_;
};

}  // namespace kasumi
