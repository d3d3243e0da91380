// One kiosk: its site, its two cameras and the building it shows.
#pragma once

#include "base/config_table.hpp"
#include "calib/adopt_calibration.hpp"
#include "calib/camera.hpp"
#include "calib/image_quality.hpp"
#include "estimator/sky/site_sky.hpp"
#include "pipeline/config/landmarks.hpp"
#include "pipeline/config/placement.hpp"

namespace kasumi {

// Fog that lies in a valley: grey, thinning with altitude as exp(-(altitude - base) / scale height). It takes light
// from what is seen through it and gives the horizon's; what falls on the object it leaves alone.
struct FogLayer {
  double extinction_per_m = 0.0;  // at the base; 0: none
  double base_altitude_m = 0.0;   // above sea level; usually that of the object's foot
  double scale_height_m = 30.0;
  friend bool operator==(const FogLayer&, const FogLayer&) = default;
};

// What lies around the object and above it.
struct Surroundings {
  double ground_albedo = 0.2;    // of sunlight, mean over the visible: grass .2, sand .35, fresh snow .8
  double cloud_base_m = 2000.0;  // above the site: where a cloud that shades the object is looked for in the sky
  FogLayer fog;
  SiteSkyModel sky_model = SiteSkyModel::automatic;  // what the clear sky looks like, by the site's altitude
  // H's lambda: standard deviation by which haze of optical depth 1 blurs what stands behind it, pixels; 0: not at all.
  double haze_blur_px = 0.0;
};

struct Installation {
  Site site;
  Surroundings surroundings;
  Camera sky;
  Camera scene;
  ImageQuality scene_quality;
  Image<float> scene_distances_m;  // of the scene camera's size, along each pixel's line of sight, 0 where nothing is
                                   // known to stand; empty: nowhere
  ObjectPlacement object;
  std::vector<Landmark> landmarks;
  std::vector<ContrastLandmark> contrast_landmarks;  // those of them that tell the visibility
  std::optional<AdoptedCalibration> calibration;     // the file beneath the one that was read

  // The clear sky of the site, whose T is estimated and drawn by; its model is never automatic.
  SkyToFit sky_to_fit() const { return {resolved(surroundings.sky_model, site.altitude_m), site.altitude_m}; }
};

// [site], [sky], [scene], [object], [[landmarks]] of a fixture or configuration, and beneath them the calibration file
// it names. Problems are left in the root's file.
Installation read_installation(const ConfigTable& root);
// For a person: which values are the calibration file's, of when, and which the root says itself in spite of it. Empty
// without such a file.
std::string calibration_summary(const Installation& installation, const std::filesystem::path& root_file);

}  // namespace kasumi
