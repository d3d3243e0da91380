// What of the camera would explain a cloudless sky that no clear sky explains: its tone curve, colours made stronger or
// weaker, light lost towards the picture's edge, or glare, which is light added everywhere. Each is tried alone, as one
// number, beside all skies.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

enum class InstrumentFault { tone_curve, colours, vignetting, glare };

struct FaultExplanation {
  InstrumentFault fault = InstrumentFault::tone_curve;
  // tone_curve: d ln(light as read) / d ln(light), 1 if the response is right. colours:
  // the same of colour differences alone. vignetting: share of the light lost at
  // the lens' edge beyond what is known. glare: added light over the sky's mean.
  double amount = 0.0;
  double log_residual = 0.0;  // what it leaves
  double aod_550 = 0.0;       // of the air then
};

struct FaultFinding {
  double log_residual = 0.0;              // root mean square of ln light that the best sky leaves, a gain per colour
  double aod_550 = 0.0;                   // of the air without any fault
  std::array<FaultExplanation, 4> tried;  // by fault
  double log_residual_of_two = 0.0;       // that tone curve and vignetting together leave
  // The one that leaves least, where it explains half of the variance and more.
  std::optional<FaultExplanation> found;
  // By how much the optical depth may be wrong since the camera may have one of them: root mean square of the shifts,
  // each as likely as the sky is better explained with it.
  double doubt_of_aod = 0.0;
};

// `readings`: of a cloudless sky, at least 30, else nothing is found.
FaultFinding find_fault(std::span<const SkyReading> readings, const SunDirection& sun, double altitude_m);

// For people: "the picture's tone curve is not that of its --response: ..."; or that none of them explains it.
std::string text_of(const FaultFinding& finding);

}  // namespace kasumi
