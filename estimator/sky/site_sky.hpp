// The clear sky above a site, by either of two models: Preetham's, which ignores altitude, or the fitted dome
// (estimator/sky/dome.hpp), which takes the observer's into account. T belongs to the model.
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

// The sky model that an estimate fits, and whose T it gives.
struct SkyToFit {
  SiteSkyModel model = SiteSkyModel::preetham;
  double altitude_m = 0.0;  // of the observer; used by the dome
};

class SiteSky {
 public:
  SiteSky(SkyModel sky) : sky_(sky) {}  // NOLINT: a sky model is a clear sky
  // `turbidity` is that of the model to which `model` resolves at this altitude.
  SiteSky(SiteSkyModel model, Turbidity turbidity, const SunDirection& sun, double altitude_m);

  // Light of the sky, CIE XYZ in units of the zenith's luminance. Finite, >= 0; at and below the horizon that of the
  // horizon.
  glm::dvec3 relative_xyz(const Direction& view) const;
  // The model's own absolute level, where it has a valid one: the dome's zenith in cd/m2.
  std::optional<double> zenith_cd_m2() const;
  // The sunlight at the same level, on a plane facing the sun: CIE XYZ, lux. Only where there is a level.
  std::optional<glm::dvec3> sun_xyz() const;
  // Preetham's model, if that is the one in use.
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
