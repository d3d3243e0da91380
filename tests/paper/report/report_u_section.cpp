#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.hpp"
#include "fixtures/atmosphere/profile.hpp"
#include "tests/fixtures/atmosphere/transmittance.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

// U Table 3.1.
struct Level {
  double altitude_km, air_k, pressure_mb, ozone_k, oxygen_km, carbon_dioxide_km, water_cm, ozone_cm;
};
constexpr Level kTable31[] = {{0, 288.1, 1013.3, 224.8, 4.9293, 4.8649, .38560, .3434},
                              {6, 249.2, 472.2, 213.69, 1.2, .9614, .07051, .3249},
                              {12, 216.6, 194, 204.42, .2302, .1484, .03489, .3064},
                              {20, 216.6, 55.29, 204.42, .0216, .0122, .00471, .2817},
                              {30, 226.5, 11.97, 207.23, .0012, .0006, .00337, .2509}};

// The paper on SMARTS2 that is bound into U prints Gueymard's air mass of molecules with the inner exponent, -1.21563,
// outside the bracket as well.
void air_masses(Section& section) {
  std::vector<std::vector<std::string>> rows;
  double most = 0.0;
  for (const double zenith_deg : {0.0, 30.0, 60.0, 75.0, 85.0, 90.0}) {
    const double right = reference::gueymard_air_mass(reference::AirMass::molecules, zenith_deg);
    const double printed = std::pow(right, 1.21563);  // (1 / m)^-1.21563
    most = std::max(most, printed / right - 1.0);
    rows.push_back({fmt::format("{:g} deg", zenith_deg), fmt::format("{:.3f}", printed), fmt::format("{:.3f}", right),
                    fmt::format("{:.3f}", 1.0 / std::cos(from_degrees(std::min(zenith_deg, 89.999)).value))});
  }
  section.say("Air mass of molecules as the paper bound into U prints it, with the exponent -1, and 1 / cos:");
  section.table({"sun from the zenith", "as printed", "with -1", "1 / cos"}, rows);
  section.figure("air_mass_most_off", most);
  section.finding(
      most < 0.02 ? Finding::reproduced : Finding::differs,
      fmt::format("U's bound paper prints the exponent of molecules' air mass twice: as printed it is {:.0f} % too "
                  "large at the horizon; with -1, as for the other gases, it is Gueymard's.",
                  100.0 * most));
}

}  // namespace

Section report_u_section(const ReportOptions&) {
  Section section("report-u", "The report of Universiti Teknologi Malaysia: U Table 3.1, its air masses");
  section.say(
      "U's atmosphere at five altitudes, from which U makes the skies of a flight simulator: standard atmosphere, "
      "paths through mixed gases, water and ozone (U Eq 3.7 to 3.13), recomputed. Each cell: U, here. U's pictures and "
      "rates of its flight simulator (U Chapter 5) belong to a program and a card that are not to be had; the three "
      "older skies that it draws are drawn by 'kasumi sky --compare', and what U's interpolation between the five "
      "altitudes costs is in docs/sky.md.");
  std::vector<std::vector<std::string>> rows;
  double worst = 0.0, worst_ozone = 0.0;
  const auto cell = [&](double theirs, double ours, int decimals, double& most) {
    // What is printed is rounded: half of its last digit is not a difference.
    const double rounding = 0.5 * std::pow(10.0, -decimals);
    most = std::max(most, std::max(0.0, std::abs(ours - theirs) - rounding) / theirs);
    return fmt::format("{0:.{2}f}, {1:.{2}f}", theirs, ours, decimals);
  };
  for (const Level& level : kTable31) {
    using namespace reference;
    const double z = 1000.0 * level.altitude_km;
    rows.push_back({fmt::format("{} km", level.altitude_km), cell(level.air_k, temperature_k(z), 1, worst),
                    cell(level.pressure_mb, pressure_mb(z), 1, worst),
                    cell(level.ozone_k, effective_ozone_temperature_k(level.air_k), 2, worst),
                    cell(level.oxygen_km, oxygen_path_km(z), 4, worst),
                    cell(level.carbon_dioxide_km, carbon_dioxide_path_km(z), 4, worst),
                    cell(level.water_cm, water_share_above(z) * kWater_cm, 5, worst),
                    cell(level.ozone_cm, kOzone_cm * ozone_correction(z), 4, worst_ozone)});
  }
  section.table({"altitude", "air, K", "pressure, mb", "ozone, K", "O2, km", "CO2, km", "water, cm", "ozone, atm-cm"},
                rows);
  air_masses(section);
  const double left = reference::ozone_share_above(30e3), theirs = reference::ozone_correction(30e3);
  section.figure("table_3_1_worst", worst);
  section.figure("ozone_left_at_30_km_by_u", theirs);
  section.figure("ozone_left_at_30_km", left);
  section.finding(worst < 0.02 && worst_ozone < 0.001 ? Finding::reproduced : Finding::differs,
                  fmt::format("U Table 3.1 comes out again within {:.2f} %, its ozone within {:.2f} %.", 100.0 * worst,
                              100.0 * worst_ozone));
  section.finding(
      std::abs(theirs / left - 1.0) < 0.2 ? Finding::reproduced : Finding::differs,
      fmt::format("U continues a correction for sites below 10 km up to 30 km, where it leaves {:.0f} % of the ozone "
                  "above; the standard layer leaves {:.0f} %, and that is what the skies here are made with.",
                  100.0 * theirs, 100.0 * left));
  return section;
}

}  // namespace kasumi::paper
