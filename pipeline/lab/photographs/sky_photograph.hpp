// One photograph of the sky: its camera, the sun's position, and the turbidity it shows.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/camera.hpp"
#include "calib/mask/image_circle.hpp"
#include "estimator/cloud_cover/cloud_cover.hpp"
#include "estimator/cloud_cover/first_look.hpp"
#include "estimator/sky_fit/tone_curve.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/lab/photographs/camera_memory.hpp"
#include "pipeline/lab/photographs/photographed_sun.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

// How to read photographs: with a calibration file, or as an ideal fisheye that looks up.
struct PhotographSetup {
  std::optional<Camera> calibrated;  // [sky] of a calibration file
  std::optional<Site> site;          // [site] of it, or --lat --lon

  bool equisolid = false;                // else equidistant
  std::optional<Radians> field_of_view;  // across the circle; empty: 180 deg, or to the horizon where that is seen
  std::optional<ImageCircle> circle;     // empty: detected in each picture
  std::optional<Radians> azimuth_up;     // empty: the camera's azimuth is not given
  bool linear_response = false;          // else sRGB
  std::optional<ToneCurve> tone;         // over sRGB
  // Neither response nor vignetting was measured: both are unknowns beside the air.
  bool unknown_camera = false;
  std::optional<double> tone_exponent;         // of an otherwise unknown camera
  bool altitude_given = false;                 // else a picture's own place may have one
  double sigma_altitude_m = 0.0;               // of the site\'s, for an unknown camera; 0: it is known
  std::optional<double> rim_loss;              // of light at the circle's edge, 0 .. 1
  std::shared_ptr<const CameraMemory> memory;  // cameras known by other pictures; null: none

  std::optional<SunDirection> sun;  // given by angles
  std::optional<Utc> utc;           // of pictures without a time of their own
  bool sun_from_image = false;
  bool allow_damaged = false;  // pictures: what is left of them is used
  // By a calibrated camera: night and closed skies may be told from the picture at an eighth of its size, where that
  // leaves no doubt. Off: report.picture is always the whole.
  bool first_look = true;

  EstimateParameters estimate;
};

struct PhotographReport {
  TurbidityObservation look;
  std::optional<SkyPicture> picture;          // empty when no camera could be determined
  std::optional<AirState> air;                // of a usable estimate
  std::optional<AirQuality> quality;          // of that air
  PhotographedSun sun;                        // its direction is empty when it was not found
  std::string damage;                         // of the file, where that is allowed; empty: none
  std::optional<ImageCircle> circle;          // in the picture's own pixels; of pixels that are not square, in rows
  std::optional<ImageCircle> horizon_circle;  // where a ring of land is seen outside the sky
  double circle_confidence = 1.0;             // that it is within 2 %; 1 where it is given
  double pixel_aspect = 1.0;                  // width of a pixel over its height
  bool mirrored = false;                      // turned over, left to right, by what the memory knows
  SizedCircle camera_circle;                  // the same circle, for the memory
  CloudCover cover;                           // given whether or not the air is
  std::optional<ToneCurve> tone;              // that was undone
  TakenAt taken;                              // what the file says
  std::optional<Utc> utc;                     // that was used
  std::optional<Site> site;                   // that was used
  bool utc_by_file = false, site_by_file = false;  // neither was given
  std::optional<double> off_m;                     // the file's place from the one given, where that contradicts it
  std::vector<std::filesystem::path> stack;        // the exposures that this picture was merged of; empty: it is none
  std::vector<double> exposure_ratios;             // of each to the shortest
};

// Estimates one picture after the other and keeps what depends only on the camera. Not thread-safe.
class PhotographEstimator {
 public:
  explicit PhotographEstimator(PhotographSetup options) : options_(std::move(options)) {}
  // Errors: bad_input (unreadable or damaged picture, size other than the calibration's). A picture without usable sky
  // is no error: its estimate gives the reason.
  Result<PhotographReport> estimate_from(const std::filesystem::path& file, std::optional<Utc> utc);
  // Of pictures taken within seconds, those that can be read as one picture, under the name of their first; empty: they
  // are no exposures of one sky (merge_exposures()).
  std::optional<PhotographReport> estimate_from_stack(const std::vector<std::filesystem::path>& files,
                                                      std::optional<Utc> utc);
  // The circle that is given or found in a picture alone. Errors: bad_input (unreadable or damaged picture).
  Result<SizedCircle> circle_in(const std::filesystem::path& file) const;

 private:
  Result<PhotographReport> estimate_of(const std::filesystem::path& file, Photograph photograph,
                                       PhotographReport report, std::optional<Utc> utc);
  struct FirstAnswer {
    PhotographReport report;
    bool sun_may_show = false;  // ClosedSky's
  };
  // Empty: one must look closer.
  std::optional<FirstAnswer> by_first_look(const std::filesystem::path& file, std::optional<Utc> utc);
  // Time and place of the call, else the file's, where the sun follows from them.
  void place(PhotographReport& report, std::optional<Utc> utc) const;
  double altitude_m(const PhotographReport& report) const;
  EstimateParameters estimate_options(const PhotographReport& report) const;
  SunGiven sun_given(const PhotographReport& report, const AzimuthFit* turn) const;
  // Whether it is night by time and place; the report then says so.
  bool answer_by_night(const SunGiven& given, PhotographReport& report) const;
  SizedCircle circle_alone(const std::filesystem::path& file, const Photograph& photograph) const;
  // Finds the circle where none is given and makes pixels square; empty: no picture of a fisheye.
  std::optional<ImageCircle> placed_circle(const std::filesystem::path& file, Photograph& photograph,
                                           PhotographReport& report) const;
  const RememberedCamera* remembered(const PhotographReport& report) const;
  void observe_by_unknown_camera(const std::filesystem::path& file, const SkyPicture& picture,
                                 PhotographReport& report);
  Camera ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle, const AzimuthFit* turn) const;

  PhotographSetup options_;
  std::optional<ImageCircle> observed_circle_;
  std::optional<SkyObserver> observer_;
  std::shared_ptr<const PixelDirections> directions_;  // of the observer's camera
  std::optional<FirstLook> first_look_;
  std::shared_ptr<const PixelDirections> first_directions_;
};

}  // namespace kasumi
