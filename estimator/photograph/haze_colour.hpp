// How a photograph's haze attenuates by wavelength, found in the picture itself: dark things take on the colour of the
// light from infinity, the more the farther they are (docs/physics.md 8).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/photograph.hpp"
#include "calib/camera.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {

struct HazeColourLimits {
  double place = 1.0 / 24.0;  // side of a place, of the picture's longer side
  double darkest = 0.05;      // share of a place's pixels that are taken for its dark things
  double faintest = 0.1;      // a place that keeps less than this of its contrast to infinity is left out
  // How ln(1 - rho) of dark things may differ by channel between near and far, sigma: as much as it does from place to
  // place, and by this at least.
  double material = 0.02;
  double infinity = 0.01;        // how the light from infinity may be off by channel, sigma; relative
  double largest_sigma = 0.5;    // of the exponent: beyond, it counts as undetermined
  double largest_scatter = 0.2;  // of places about their line, in ln(1 - L/Linf): beyond, materials hide the haze
};

struct HazeColour {
  bool told = false;
  std::string reason;        // for people: why the exponent is undetermined; else empty
  double exponent = 0.0;     // Angstrom's: extinction goes with wavelength^-exponent, that of molecules included
  double sigma = 0.0;        // standard deviation of the exponent
  double depth = 0.0;        // optical depth of green, of the middle of the places
  double depth_range = 0.0;  // optical depth of green from the nearest to the farthest twentieth of the places
  double scatter = 0.0;      // of the places about their line, in ln(1 - L/Linf)
  int places = 0;            // that were used
};

// Koschmieder: ln(1 - L/Linf) = -beta_c d + ln(1 - rho_c). For dark things the last term is small and the same near and
// far, so places at all distances lie along a line whose direction is beta_c; and as it is nearly zero, beta_c d itself
// is observed, too. Either yields the exponent; their mean is weighted. No distances are needed; exposure and white
// balance cancel. `relative`: L/Linf, linear; `sky`: 255 where sky, or empty; `wavelength_nm`: of the channels.
// Undetermined, with the reason: exponents of the channels that disagree, too little depth, too few places.
HazeColour haze_colour(const Image<glm::vec3>& relative, const Image<std::uint8_t>& sky,
                       const glm::dvec3& wavelength_nm, const HazeColourLimits& options = {});

// A photograph in units of its light from infinity: its low sky's, or where no sky is seen that of its thickest haze,
// which is trusted less.
struct HazyPicture {
  Image<glm::vec3> relative;   // L/Linf, linear
  Image<std::uint8_t> sky;     // 255 where sky; empty: none is seen
  glm::dvec3 from_infinity{};  // the mean, linear, in the camera's channels and scale
  bool from_sky = false;
};
HazyPicture hazy_picture(const Camera& camera, const Photograph& photograph);
HazeColour haze_colour_of(const Camera& camera, const HazyPicture& picture, HazeColourLimits options = {});

// Pixels of a picture.
struct HazyPart {
  int left = 0, top = 0, width = 0, height = 0;
};
// How a part of a picture stands out from the smooth sky beside it, at its own height: 1 - mean of the part / mean of
// that sky; where none is beside it, how the part's darkest twentieth does from the light from infinity as it was read.
// Nothing: the part is outside of the picture.
struct PartContrast {
  glm::dvec3 contrast{0.0}, sigma{0.0};
  double infinity_sigma = 0.0;  // by which the light from infinity behind it may differ from what it was compared with
  double spread = 0.0;          // by how much what was compared is brighter than its darkest twentieth: many materials
};
std::optional<PartContrast> part_contrast(const HazyPicture& picture, const HazyPart& box);

// Where a channel stands in Angstrom's law: the geometric mean wavelength of its measure.
glm::dvec3 channel_wavelengths_nm(const Camera& camera);
// The aerosol's exponent in air like `air`, of which molecules are a known part.
double aerosol_exponent(const HazeColour& colour, const AirState& air);

}  // namespace kasumi
