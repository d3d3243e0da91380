// One photograph of the sky by itself: which camera took it, where its sun stood, what air it shows.
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

// How to read photographs. Either a calibration file or the few numbers of an ideal fisheye that looks up.
struct SkyPhotographOptions {
  std::optional<Camera> calibrated;  // [sky] of a calibration file
  std::optional<Site> site;          // [site] of it, or --lat --lon

  bool equisolid = false;  // else equidistant
  Radians field_of_view = from_degrees(180.0);
  std::optional<ImageCircle> circle;  // found in each picture when not given
  Radians azimuth_up{};
  bool linear_response = false;  // else sRGB

  std::optional<SunDirection> sun;  // given by angles
  std::optional<Utc> utc;           // of pictures that bring no time of their own
  bool sun_from_image = false;

  EstimateOptions estimate;
};

struct SkyPhotographReport {
  SkyLook look;
  std::optional<SkyPicture> picture;  // what was looked at; empty when no camera could be made of it
  std::optional<AirQuality> air;      // of a usable estimate
  std::optional<SunDirection> sun;    // empty when it was not to be found
  std::string sun_source;             // where that direction comes from
  std::optional<ImageCircle> circle;
};

// Looks at one picture after the other; keeps what depends on the camera alone. Not for two threads at once.
class SkyPhotographs {
 public:
  explicit SkyPhotographs(SkyPhotographOptions options) : options_(std::move(options)) {}
  // Errors: bad_input (unreadable picture, size other than the calibration's). A picture that shows no usable sky is no
  // error: its estimate says why.
  Result<SkyPhotographReport> estimate_from(const std::filesystem::path& file, std::optional<Utc> utc);

 private:
  Camera ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle) const;

  SkyPhotographOptions options_;
  std::optional<ImageCircle> observed_circle_;
  std::optional<SkyObserver> observer_;
};

}  // namespace kasumi
