// One kiosk: its site, its two cameras and the building it shows.
#pragma once

#include "base/table/config_table.hpp"
#include "calib/adopt_calibration.hpp"
#include "calib/camera.hpp"
#include "calib/image_quality.hpp"
#include "estimator/given_air.hpp"
#include "estimator/light/card_light.hpp"
#include "estimator/sky/site_sky.hpp"
#include "pipeline/site/config/landmarks.hpp"
#include "pipeline/site/config/placement.hpp"

namespace kasumi {

// Fog in a valley, part of the air's state (physics 12): grey, thinning with altitude as exp(-(altitude - base) / scale height). It replaces light from what
// is seen through it by the horizon's; the light that falls on the object stays unchanged.
struct FogLayer {
  double extinction_per_m = 0.0;  // at the base; 0: none
  double base_altitude_m = 0.0;   // above sea level; usually that of the object's foot
  double scale_height_m = 30.0;
  friend bool operator==(const FogLayer&, const FogLayer&) = default;
};

// The object's surroundings and the sky above.
struct Surroundings {
  double ground_albedo = 0.2;    // of sunlight, mean over the visible: grass .2, sand .35, fresh snow .8
  double cloud_base_m = 2000.0;  // above the site: a cloud there may shade the object
  FogLayer fog;
  // Model of the clear sky; automatic: all are fitted and weighted, and the estimated air decides which is drawn.
  DaylightModel sky_model = DaylightModel::automatic;
  GivenAir air;  // what is known of it; the rest is found
  // H's lambda: blur of what lies behind haze of optical depth 1, standard deviation in pixels; 0: none.
  double haze_blur_px = 0.0;
};

struct Installation {
  Site site;
  Surroundings surroundings;
  Camera sky;
  Camera scene;
  ImageQuality scene_quality;
  // By which scene.response, sRGB's, was corrected: as landmarks tell it (contrast_tone). Empty: not at all.
  std::optional<double> scene_tone_exponent{};
  Image<float> scene_distances_m;  // of the scene camera's size, along each pixel's line of sight, 0 where nothing is
                                   // known to stand; empty: nowhere
  std::string depth_map;           // what that map knows, for people; empty: there is none
  bool people_in_front = false;    // people, birds and vehicles before the building stay in front of it
  ObjectPlacement object;
  std::vector<Landmark> landmarks;
  std::vector<ContrastLandmark> contrast_landmarks;  // those used to measure visibility
  std::vector<LightCard> cards{};
  std::optional<AdoptedCalibration> calibration;  // the calibration file it builds on

  // How the air is estimated from the sky camera's picture: by every model, or by the chosen one, which is never
  // automatic.
  ModelToFit model_to_fit() const;
  // The scene camera's: scene.saturation; 1 where its colours or tone curve were measured, since such a camera shows
  // colours as they were found. Empty: it is learnt.
  std::optional<double> given_saturation() const;
};

// Reads [site], [sky], [scene], [object], [[landmarks]] of a fixture or configuration on top of the calibration file it
// names. Problems are collected in the root's file.
Installation read_installation(const ConfigTable& root);
// For a person: which values come from the calibration file, of what date, and which of them the root overrides. Empty
// without a calibration file.
std::string calibration_summary(const Installation& installation, const std::filesystem::path& root_file);

}  // namespace kasumi
