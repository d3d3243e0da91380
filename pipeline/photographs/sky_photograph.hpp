// One photograph of the sky: its camera, the sun's position, and the turbidity it shows.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/camera.hpp"
#include "calib/mask/image_circle.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/files/photograph_file.hpp"

namespace kasumi {

// How to read photographs: with a calibration file, or as an ideal fisheye that looks up.
struct SkyPhotographOptions {
  std::optional<Camera> calibrated;  // [sky] of a calibration file
  std::optional<Site> site;          // [site] of it, or --lat --lon

  bool equisolid = false;  // else equidistant
  Radians field_of_view = from_degrees(180.0);
  std::optional<ImageCircle> circle;  // empty: detected in each picture
  Radians azimuth_up{};
  bool linear_response = false;  // else sRGB

  std::optional<SunDirection> sun;  // given by angles
  std::optional<Utc> utc;           // of pictures without a time of their own
  bool sun_from_image = false;

  EstimateOptions estimate;
};

struct SkyPhotographReport {
  SkyObservation look;
  std::optional<SkyPicture> picture;  // empty when no camera could be determined
  std::optional<AirQuality> air;      // of a usable estimate
  std::optional<SunDirection> sun;    // empty when it was not found
  std::string sun_source;             // how that direction was determined
  std::optional<ImageCircle> circle;
};

// Estimates one picture after the other and keeps what depends only on the camera. Not thread-safe.
class SkyPhotographs {
 public:
  explicit SkyPhotographs(SkyPhotographOptions options) : options_(std::move(options)) {}
  // Errors: bad_input (unreadable picture, size other than the calibration's). A picture without usable sky is no
  // error: its estimate gives the reason.
  Result<SkyPhotographReport> estimate_from(const std::filesystem::path& file, std::optional<Utc> utc);

 private:
  Camera ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle) const;

  SkyPhotographOptions options_;
  std::optional<ImageCircle> observed_circle_;
  std::optional<SkyObserver> observer_;
};

}  // namespace kasumi
