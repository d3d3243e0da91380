#include "tests/estimator/sky_fit/strange_skies.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "calib/colour/colorimetry.hpp"
#include "fixtures/atmosphere/optics.hpp"

namespace kasumi::test {
namespace {

using reference::Air;
using reference::Optics;

struct StrangeAir {
  std::string name;
  Aerosol aerosol;
  Optics optics;
};

// Of the depth of an exponent, scattering by one lobe.
StrangeAir of_lobe(double aod, double asymmetry) {
  const Air air{.aerosol = {aod, 1.4, AerosolKind::continental}};
  Optics optics = optics_of(air);
  for (std::size_t w = 0; w < optics.size(); ++w) {
    optics.aerosol_phase[w] = reference::one_lobe(asymmetry);
    optics.aerosol_scattering[w] =
        optics.extinction[reference::kAerosol][w] * reference::spctral2_albedo(optics.wavelength_nm[w]);
  }
  return {fmt::format("one lobe of {}", asymmetry), air.aerosol, std::move(optics)};
}

StrangeAir over_ground(const Aerosol& aerosol, double albedo) {
  const Air air{.aerosol = aerosol, .ground_albedo = albedo};
  return {fmt::format("ground of {}", albedo), aerosol, optics_of(air)};
}

StrangeAir tilted(AerosolKind kind, double aod, double by) {
  const Air air{.aerosol = {aod, natural_exponent(kind) + by, kind}};
  return {"another exponent", air.aerosol, optics_of(air)};
}

StrangeAir unpolarised(double aod) {
  const Air air{.aerosol = {aod, natural_exponent(AerosolKind::continental), AerosolKind::continental}};
  Optics optics = optics_of(air);
  optics.polarised = false;
  return {"unpolarised light", air.aerosol, std::move(optics)};
}

StrangeAir spctral2(double aod) {
  const Air air{.aerosol = {aod, 1.3, AerosolKind::continental}};
  return {"SPCTRAL2's haze", air.aerosol, spctral2_optics_of(air)};
}

StrangeAir mixed(AerosolKind one, AerosolKind other, double aod) {
  const Air a{.aerosol = {aod / 2.0, natural_exponent(one), one}},
      b{.aerosol = {aod / 2.0, natural_exponent(other), other}};
  Optics optics = optics_of(a);
  const Optics more = optics_of(b);
  for (std::size_t w = 0; w < optics.size(); ++w) {
    const double s = optics.aerosol_scattering[w], t = more.aerosol_scattering[w];
    reference::PhaseCurve both;
    both.value = [s, t, p = optics.aerosol_phase[w], q = more.aerosol_phase[w]](double cosine) {
      return (s * p.value(cosine) + t * q.value(cosine)) / (s + t);
    };
    for (std::size_t l = 0; l < both.moments.size(); ++l)
      both.moments[l] = (s * optics.aerosol_phase[w].moments[l] + t * more.aerosol_phase[w].moments[l]) / (s + t);
    optics.aerosol_phase[w] = both;
    optics.aerosol_scattering[w] = s + t;
    optics.extinction[reference::kAerosol][w] += more.extinction[reference::kAerosol][w];
  }
  const auto depth = [&](double nm) { return optical_depth(a.aerosol, nm) + optical_depth(b.aerosol, nm); };
  return {fmt::format("{} and {}", name_of(one), name_of(other)),
          {aod, -std::log(depth(650.0) / depth(450.0)) / std::log(650.0 / 450.0), one},
          std::move(optics)};
}

std::vector<StrangeAir> developed_airs(const std::vector<double>& aods) {
  using enum AerosolKind;
  std::vector<StrangeAir> airs;
  for (const double aod : aods) {
    for (const double asymmetry : {0.55, 0.62, 0.75}) airs.push_back(of_lobe(aod, asymmetry));
    for (const double ground : {0.05, 0.6}) airs.push_back(over_ground({aod, 1.32, continental}, ground));
    for (const double by : {-0.25, 0.25})
      for (const AerosolKind kind : {continental, desert, smoke}) airs.push_back(tilted(kind, aod, by));
    airs.push_back(unpolarised(aod));
    airs.push_back(spctral2(aod));
    airs.push_back(mixed(continental, maritime, aod));
  }
  return airs;
}

std::vector<StrangeAir> held_out_airs(const std::vector<double>& aods) {
  using enum AerosolKind;
  std::vector<StrangeAir> airs;
  for (const double aod : aods) {
    for (const double asymmetry : {0.59, 0.68}) airs.push_back(of_lobe(aod, asymmetry));
    for (const double ground : {0.1, 0.35}) airs.push_back(over_ground({aod, 1.34, urban}, ground));
    for (const double by : {-0.2, 0.2})
      for (const AerosolKind kind : {polluted, urban, maritime, dust}) airs.push_back(tilted(kind, aod, by));
    airs.push_back(mixed(polluted, desert, aod));
    airs.push_back(mixed(smoke, continental, aod));
  }
  return airs;
}

std::vector<SkyReading> read(const reference::ReferenceSky& sky, double altitude_m, const SunDirection& sun,
                             const ReadingFaults& faults) {
  return readings_of(
      spread_directions(sun, 200, 8.0),
      [&](const Direction& view) {
        return xyz_to_linear_srgb() * sky.xyz({altitude_m, view, sun});
      },
      faults);
}

}  // namespace

std::map<std::string, std::vector<StrangeSky>> strange_skies(StrangeSet set) {
  std::map<std::string, std::vector<StrangeSky>> skies;
  const bool few = set == StrangeSet::developed_few || set == StrangeSet::held_out_few;
  if (set == StrangeSet::developed || set == StrangeSet::developed_few) {
    for (const StrangeAir& air : developed_airs(few ? std::vector{0.12} : std::vector{0.045, 0.12, 0.35}))
      for (const double zenith_deg : few ? std::vector{50.0} : std::vector{28.0, 50.0, 68.0}) {
        const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(40.0));
        const reference::ReferenceSky sky(air.optics, reference::suns_around_deg(zenith_deg));
        skies[air.name].push_back({air.aerosol, 300.0, sun, {}, read(sky, 300.0, sun, {})});
      }
    return skies;
  }
  // In turn: a balance that is off, vignetting, noise; altitudes.
  const std::array<ReadingFaults, 4> faults{{{.noise = 0.01},
                                             {.log_red = 0.1, .log_blue = -0.1},
                                             {.vignetting = -0.2},
                                             {.log_red = -0.07, .log_blue = -0.12, .vignetting = 0.15}}};
  const std::array altitudes_m{0.0, 350.0, 2000.0};
  std::size_t turn = 0;
  for (const StrangeAir& air : held_out_airs(few ? std::vector{0.2} : std::vector{0.07, 0.2, 0.6}))
    for (const double zenith_deg : few ? std::vector{42.0} : std::vector{20.0, 42.0, 74.0}) {
      ReadingFaults fault = faults[turn % faults.size()];
      fault.seed = turn;
      const double altitude_m = altitudes_m[turn % altitudes_m.size()];
      const InstrumentDoubt doubt{true, 0.1, fault.vignetting != 0.0 ? 0.2 : 0.0};
      const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(190.0));
      const reference::ReferenceSky sky(air.optics, reference::suns_around_deg(zenith_deg));
      skies[air.name].push_back({air.aerosol, altitude_m, sun, doubt, read(sky, altitude_m, sun, fault)});
      ++turn;
    }
  return skies;
}

}  // namespace kasumi::test
