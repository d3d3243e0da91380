// The clear sky of Hosek and Wilkie (2012, 2013) from their published data, which the user brings in a file.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "base/result.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

constexpr double kHosekGroundAlbedo = 0.2;  // as under the dome

// One wavelength or colour of one sky: nine numbers and a mean radiance.
struct HosekForm {
  std::array<double, 9> shape{};
  double radiance = 0.0;
};

// Their sky for one turbidity, ground and sun; cheap to ask for many directions.
class HosekRadiance {
 public:
  HosekRadiance(const std::array<HosekForm, 3>& colours, const SunDirection& sun) : colours_(colours), sun_(sun) {}

  // Linear sRGB in W m-2 sr-1 nm-1 (weighted by the eye's response); at and below the horizon that of the horizon.
  glm::dvec3 linear_srgb(const Direction& view) const { return linear_srgb(view.z, glm::dot(view, sun_)); }
  // Of the cosines of the angles to the zenith and to the sun.
  glm::dvec3 linear_srgb(double cos_zenith, double cos_sun_distance) const;

 private:
  std::array<HosekForm, 3> colours_;
  SunDirection sun_;
};

class HosekSky {
 public:
  static constexpr int kWavelengths = 11;                      // as their data: 320 to 720 nm, T 1 to 10
  static constexpr double kFirst_nm = 320.0, kStep_nm = 40.0;  // as their data
  static constexpr Turbidity kLowest{1.0}, kHighest{10.0};     // as their data

  // One file of their data (docs/sky.md gives its layout). Errors: bad_input.
  static Result<HosekSky> read_file(const std::filesystem::path& file);

  // T 1 to 10, albedo of the ground 0 to 1, the sun above the horizon; clamped.
  HosekRadiance sky(Turbidity turbidity, double ground_albedo, const SunDirection& sun) const;
  glm::dvec3 linear_srgb(Turbidity turbidity, double ground_albedo, const SunDirection& sun,
                         const Direction& view) const {
    return sky(turbidity, ground_albedo, sun).linear_srgb(view);
  }
  // W m-2 sr-1 nm-1 from one direction at 320, 360 ... 720 nm, by their spectral data.
  std::array<double, kWavelengths> spectral_radiance(Turbidity turbidity, double ground_albedo, const SunDirection& sun,
                                                     const Direction& view) const;

 private:
  // By turbidity, albedo, control point over the sun's elevation, channel.
  struct Tables {
    int channels = 0;
    std::vector<double> shape, radiance;
    HosekForm form(int channel, double turbidity, double ground_albedo, double sun_elevation_rad) const;
  };
  Tables rgb_, spectral_;
};

}  // namespace kasumi
