// The clear sky above a site, by either of two models: Preetham's, which knows T alone and ignores altitude, or the
// fitted dome (estimator/sky/dome.hpp), which takes the aerosol and the observer's altitude into account. An estimated T
// belongs to the model.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include <glm/vec3.hpp>

#include "estimator/given_air.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/preetham.hpp"

namespace kasumi {

class HosekSky;  // estimator/sky/hosek.hpp

// automatic: the dome where the aerosol is known, and above kHighestPreethamSite_m; Preetham's elsewhere, with the dome
// in its place under a low sun.
enum class DaylightModel { automatic, preetham, dome };
std::string_view name_of(DaylightModel model);
std::optional<DaylightModel> daylight_model_named(std::string_view name);
constexpr double kHighestPreethamSite_m = 1500.0;  // above, the dome is drawn (docs/physics.md 12)
DaylightModel resolved(DaylightModel model, double altitude_m, bool aerosol_known = false);  // never automatic

// Preetham's chromaticities turn olive under a low sun. Between these elevations his sky fades into the dome of the same
// optical depth, so that nothing jumps.
constexpr Radians kDomeAloneBelow = from_degrees(12.0), kPreethamAloneAbove = from_degrees(16.0);

// The sky model that an estimate fits, and whose T it gives.
struct ModelToFit {
  DaylightModel model = DaylightModel::preetham;
  double altitude_m = 0.0;  // of the observer; used by the dome
  // The dome's aerosol, of which only the amount is unknown; empty: the dome's usual one, T 1.7 to 10.
  std::optional<Aerosol> aerosol = std::nullopt;
  // All models are fitted and weighted (estimator/sky_fit), with what `known` gives of the aerosol; `model` and
  // `aerosol` then say which of them was followed.
  bool every_model = false;
  GivenAir known = {};
  std::shared_ptr<const HosekSky> hosek = nullptr;  // asked as well, or alone if not every_model; null: not asked
};

class SiteSky {
 public:
  SiteSky(PreethamSky sky) : preetham_(sky) {}  // NOLINT: a sky model is a clear sky
  // The T of `air` is that of the model to which `model` resolves.
  SiteSky(DaylightModel model, const AirState& air, const SunDirection& sun, double altitude_m);

  // Light of the sky, CIE XYZ in units of the zenith's luminance. Finite, >= 0; at and below the horizon that of the
  // horizon: the level for Preetham's sky, the geometric horizon of the site's altitude for the dome.
  glm::dvec3 relative_xyz(const Direction& view) const;
  // 0: Preetham's alone; 1: the dome alone.
  double dome_share() const { return dome_share_; }
  // The dome's own absolute level, where it has a share (Preetham's is not valid): its zenith in cd/m2.
  std::optional<double> zenith_cd_m2() const;
  // The sunlight at the same level, on a plane facing the sun: CIE XYZ, lux.
  std::optional<glm::dvec3> sun_xyz() const;
  // Preetham's model, if that is the site's (even where the dome has its place under a low sun).
  const PreethamSky* preetham() const { return preetham_ ? &*preetham_ : nullptr; }

 private:
  struct Dome {
    DomeFunction light;
    double zenith_cd_m2 = 1.0;
    glm::dvec3 sun_xyz{0.0};
  };
  std::optional<PreethamSky> preetham_;
  std::optional<Dome> dome_;
  double dome_share_ = 0.0;
};

}  // namespace kasumi
