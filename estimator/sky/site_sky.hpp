// The clear sky above a site, by either of two models: Preetham's, which knows no altitude, or the fitted dome
// (estimator/sky/dome.hpp), which knows the observer's. T is the model's own.
#pragma once

#include <optional>
#include <string_view>
#include <variant>

#include <glm/vec3.hpp>

#include "estimator/sky/dome.hpp"
#include "estimator/sky/sky_model.hpp"

namespace kasumi {

// automatic: Preetham's up to kHighestPreethamSite_m above the sea, the dome above.
enum class SiteSkyModel { automatic, preetham, dome };
std::string_view name_of(SiteSkyModel model);
std::optional<SiteSkyModel> site_sky_model_named(std::string_view name);
constexpr double kHighestPreethamSite_m = 1500.0;
SiteSkyModel resolved(SiteSkyModel model, double altitude_m);  // never automatic

// The sky that an estimate fits: whose T it finds.
struct SkyToFit {
  SiteSkyModel model = SiteSkyModel::preetham;
  double altitude_m = 0.0;  // of the observer; the dome knows it
};

class SiteSky {
 public:
  SiteSky(SkyModel sky) : sky_(sky) {}  // NOLINT: a sky model is a clear sky
  // `turbidity` is that of the model that `model` means at this altitude.
  SiteSky(SiteSkyModel model, Turbidity turbidity, const SunDirection& sun, double altitude_m);

  // Light of the sky, CIE XYZ with the zenith's luminance as unit. Finite, >= 0; at and below the horizon the
  // horizon's.
  glm::dvec3 relative_xyz(const Direction& view) const;
  // The model's own level, where it has one that holds: the dome's zenith in cd/m2.
  std::optional<double> zenith_cd_m2() const;
  // The sun's light that comes with it, on a plane facing the sun: CIE XYZ, lux. Only where there is a level.
  std::optional<glm::dvec3> sun_xyz() const;
  // Preetham's, where it is his.
  const SkyModel* preetham() const { return std::get_if<SkyModel>(&sky_); }

 private:
  struct Dome {
    DomeFunction light;
    double zenith_cd_m2 = 1.0;
    glm::dvec3 sun_xyz{0.0};
  };
  std::variant<SkyModel, Dome> sky_;
};

}  // namespace kasumi
