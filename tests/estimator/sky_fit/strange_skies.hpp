// Skies that no model of ours has: other phase functions, grounds, mixtures and exponents, from other altitudes and
// through instruments that err.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/estimator/sky_fit/skies_as_readings.hpp"

namespace kasumi::test {

struct StrangeSky {
  Aerosol aerosol;  // as near as the kinds can say it
  double altitude_m = 0.0;
  SunDirection sun{0.0, 0.0, 1.0};
  InstrumentDoubt doubt;
  std::vector<SkyReading> readings;
};

// developed: the fit's sigmas were set by these. held_out: nothing was.
enum class StrangeSet { developed, developed_few, held_out, held_out_few };
std::map<std::string, std::vector<StrangeSky>> strange_skies(StrangeSet set);

// The scanner at Cornell is a calibrated spectrometer.
inline const InstrumentDoubt kScanner{true, 0.03, 0.0};

}  // namespace kasumi::test
