// Everything known about one camera: orientation, lens, radiometry.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <glm/mat3x3.hpp>

#include "base/clock.hpp"
#include "base/geometry.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/table/config_table.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "calib/lens/lens.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

struct Camera {
  std::string name;  // "sky", "scene"
  int width = 0;
  int height = 0;
  LensPtr lens;
  glm::dmat3 to_world{1.0};  // camera frame to world frame
  Response response = Response::srgb();
  Vignetting vignetting;
  YuvEncoding yuv_encoding = YuvEncoding::bt601_full;
  SpectralSensitivity sensitivity = generic_sensitivity();
  // sensor: channel c is white_balance[c] * integral of L q_c. srgb: the camera has converted to linear sRGB before its
  // response curve.
  enum class ColourSpace { sensor, srgb } colour_space = ColourSpace::srgb;
  glm::dvec3 white_balance{1.0};
  Image<std::uint8_t> mask;  // empty, or one value per pixel: sky camera: 0 where obstructed; scene camera: 0 where
                             // something stands in front of the object
  std::optional<Utc> calibrated_utc;  // last calibration; informative only

  std::optional<Direction> direction_at(const glm::dvec2& pixel) const;  // world frame
  std::optional<glm::dvec2> pixel_of(const Direction& direction) const;
  // Linear light of an encoded pixel, vignetting and white balance removed. Units: the camera's full scale = 1 at the
  // centre.
  glm::dvec3 light_at(const glm::dvec2& pixel, const glm::dvec3& encoded) const;
  // Converts that light to XYZ; exact for sky light when the sensitivity is known.
  glm::dmat3 light_to_xyz() const;
};

// Where the two cameras stand.
struct Site {
  std::string name;
  double latitude_deg = 0.0;   // north positive
  double longitude_deg = 0.0;  // east positive
  double altitude_m = 0.0;
};

Site read_site(const ConfigTable& table);
// [sky] or [scene] of a fixture or configuration. Problems are recorded in the table.
Camera read_camera(const ConfigTable& table, std::string name);

}  // namespace kasumi
