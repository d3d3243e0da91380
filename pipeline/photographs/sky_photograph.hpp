// One photograph of the sky: its camera, the sun's position, and the turbidity it shows.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/camera.hpp"
#include "calib/mask/image_circle.hpp"
#include "estimator/sky_fit/tone_curve.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/files/photograph_file.hpp"
#include "pipeline/photographs/photographed_sun.hpp"

namespace kasumi {

// How to read photographs: with a calibration file, or as an ideal fisheye that looks up.
struct SkyPhotographOptions {
  std::optional<Camera> calibrated;  // [sky] of a calibration file
  std::optional<Site> site;          // [site] of it, or --lat --lon

  bool equisolid = false;  // else equidistant
  Radians field_of_view = from_degrees(180.0);
  std::optional<ImageCircle> circle;  // empty: detected in each picture
  std::optional<Radians> azimuth_up;  // empty: nobody said how the camera was turned
  bool linear_response = false;       // else sRGB
  std::optional<ToneCurve> tone;      // over sRGB

  std::optional<SunDirection> sun;  // given by angles
  std::optional<Utc> utc;           // of pictures without a time of their own
  bool sun_from_image = false;
  bool allow_damaged = false;  // pictures: what is left of them is used

  EstimateOptions estimate;
};

struct SkyPhotographReport {
  SkyObservation look;
  std::optional<SkyPicture> picture;  // empty when no camera could be determined
  std::optional<AirState> air;        // of a usable estimate
  std::optional<AirQuality> quality;  // of that air
  PhotographedSun sun;                // its direction is empty when it was not found
  std::string damage;                 // of the file, where that is allowed; empty: none
  std::optional<ImageCircle> circle;
  std::optional<ToneCurve> tone;  // that was undone
};

// Estimates one picture after the other and keeps what depends only on the camera. Not thread-safe.
class SkyPhotographs {
 public:
  explicit SkyPhotographs(SkyPhotographOptions options) : options_(std::move(options)) {}
  // Errors: bad_input (unreadable or damaged picture, size other than the calibration's). A picture without usable sky is no
  // error: its estimate gives the reason.
  Result<SkyPhotographReport> estimate_from(const std::filesystem::path& file, std::optional<Utc> utc);

 private:
  double altitude_m() const;
  SunGiven sun_given(const std::optional<Utc>& utc) const;
  Camera ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle) const;

  SkyPhotographOptions options_;
  std::optional<ImageCircle> observed_circle_;
  std::optional<SkyObserver> observer_;
};

}  // namespace kasumi
