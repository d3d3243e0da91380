// Light under known air, against the spectral atmosphere (fixtures/atmosphere): where the light on the object and the
// light at the horizon come from, and what their ratio costs in a picture.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/colour_difference.hpp"
#include "base/geometry.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/light/airlight.hpp"
#include "estimator/light/object_light.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "tests/estimator/light/light_behind_air.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

using test::at;
using test::Budget;
using test::Estimated;
using test::steps;
using test::text_of;
using test::Truth;

struct Case {
  double turbidity, sun_deg;
};
constexpr std::array kCases{Case{2.4, 31.0}, Case{2.4, 62.0}, Case{4.0, 31.0},
                            Case{4.0, 62.0}, Case{7.0, 31.0}, Case{7.0, 62.0}};

TEST(AirTruthLight, TheEnergyBudgetUnderKnownAir) {
  double worst_dome = 0.0, sum_dome = 0.0, sum_preetham = 0.0;
  for (const auto& [turbidity, sun_deg] : kCases) {
    const double exponent = natural_exponent(AerosolKind::continental);
    const Aerosol aerosol = aerosol_of(turbidity, exponent);
    const Truth truth(aerosol, sun_deg);
    const Estimated preetham(Turbidity{turbidity}, sun_deg), dome(aerosol, sun_deg);
    fmt::print("\nT {} (AOD {:.3f}), sun {} deg high: program / spectral atmosphere, red green blue\n", turbidity,
               aerosol.aod_550, sun_deg);
    fmt::print("{:8} {:4} {:>17} {:>17} {:>17} {:>17} {:>17} {:>17}\n", "", "from", "sun", "sky on ground",
               "wall, no sun", "horizon", "ground/horizon", "wall/horizon");
    double errors[2] = {}, with_gamma[2] = {};
    int count = 0;
    for (const double azimuth : {45.0, 100.0, 170.0}) {  // from the sun
      const Budget real = truth.budget(at(0.0, azimuth));
      const auto ratio = [&](const Budget& b) {
        return std::pair{(b.sun * std::sin(from_degrees(sun_deg).value) + b.sky) / b.horizon, b.wall / b.horizon};
      };
      const glm::dvec3 measured = truth.light(at(2.0, azimuth));
      int way = 0;
      for (const Estimated* way_of : {&preetham, &dome}) {
        const Budget found = way_of->budget(at(0.0, azimuth));
        fmt::print("{:8} {:4.0f} {:>17} {:>17} {:>17} {:>17} {:>17} {:>17}\n", way == 0 ? "Preetham" : "dome", azimuth,
                   text_of(found.sun / real.sun), text_of(found.sky / real.sky), text_of(found.wall / real.wall),
                   text_of(found.horizon / real.horizon), text_of(ratio(found).first / ratio(real).first),
                   text_of(ratio(found).second / ratio(real).second));
        for (const double distance_m : {500.0, 2000.0, 5000.0})
          for (const bool wall : {false, true}) {
            const glm::dvec3 real_picture = truth.seen(at(0.0, azimuth), distance_m, wall);
            const glm::dvec3 gamma = truth.gamma(at(0.0, azimuth), distance_m);
            errors[way] +=
                steps(way_of->seen(at(0.0, azimuth), distance_m, wall, measured, nullptr), real_picture, measured.g);
            with_gamma[way] +=
                steps(way_of->seen(at(0.0, azimuth), distance_m, wall, measured, &gamma), real_picture, measured.g);
          }
        ++way;
      }
      count += 6;
    }
    fmt::print("{:>21} {} | {}  Gamma over 2 km, true | Preetham's way {} | the dome's {}\n", "", "", "",
               text_of(preetham.gamma(2000.0) / truth.gamma(at(0.0, 100.0), 2000.0)),
               text_of(dome.gamma(2000.0) / truth.gamma(at(0.0, 100.0), 2000.0)));
    fmt::print(
        "level ground and walls of albedo .3 at .5, 2, 5 km: Preetham's {:.1f} of 255 ({:.1f} with true Gamma), "
        "dome's {:.1f} ({:.1f})\n",
        errors[0] / count, with_gamma[0] / count, errors[1] / count, with_gamma[1] / count);
    worst_dome = std::max(worst_dome, errors[1] / count);
    sum_dome += errors[1] / count;
    sum_preetham += errors[0] / count;
  }
  fmt::print("\nall: Preetham's {:.1f}, dome's {:.1f} of 255 (worst {:.1f}; goal 2)\n",
             sum_preetham / static_cast<double>(kCases.size()), sum_dome / static_cast<double>(kCases.size()),
             worst_dome);
  figure_row("given-light",
             {"walls and ground under sky and sun, .5 to 5 km, mean of all airs and suns; worst",
              figure_text(sum_dome / static_cast<double>(kCases.size()), 1) + "; " + figure_text(worst_dome, 1), "2",
              "`test_air_truth_light`"});
  EXPECT_LE(worst_dome, 2.0);
  EXPECT_GT(sum_preetham, 2.0 * sum_dome) << "else the way does not matter";
}

// The dome's table stands over ground of albedo .2; sand and snow light the sky from below.
TEST(AirTruthLight, BrightGroundLightsTheSkyToo) {
  fmt::print(
      "\nground of other albedos: program / spectral atmosphere, sky on ground, wall, horizon, wall/horizon; in "
      "brackets as over albedo .2\n");
  for (const auto& [turbidity, kind] :
       {std::pair{2.4, AerosolKind::continental}, {5.0, AerosolKind::continental}, {4.0, AerosolKind::dust}})
    for (const double albedo : {0.05, 0.35, 0.8}) {
      const Aerosol aerosol = aerosol_of(turbidity, natural_exponent(kind), kind);
      const double sun_deg = 40.0;
      const Truth truth(aerosol, sun_deg, albedo);
      const Estimated with(aerosol, sun_deg, albedo), without(aerosol, sun_deg);
      const Direction view = at(0.0, 110.0);
      const Budget real = truth.budget(view), found = with.budget(view), plain = without.budget(view);
      fmt::print("T {} {:12} albedo {:.2f}: {} | {} | {} ({}) | {} ({})\n", turbidity, name_of(kind), albedo,
                 text_of(found.sky / real.sky), text_of(found.wall / real.wall), text_of(found.horizon / real.horizon),
                 text_of(plain.horizon / real.horizon), text_of(found.wall / found.horizon * real.horizon / real.wall),
                 text_of(found.wall / plain.horizon * real.horizon / real.wall));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found.sky[c] / real.sky[c], 1.0, 0.06);
        EXPECT_NEAR(found.wall[c] / found.horizon[c] * real.horizon[c] / real.wall[c], 1.0, 0.12);
      }
    }
}

// What the program shows of a clear sky on low land, T given, against the spectral atmosphere of the same optical depth.
TEST(AirTruthLight, SkiesOfALowSunHaveTheRightColours) {
  double sum = 0.0, sum_preetham = 0.0;
  int count = 0;
  fmt::print("\nlow sun, CIEDE2000 in the mean over the sky: T, sun's elevation, Preetham's, the program's\n");
  for (const double turbidity : {2.2, 4.0})
    for (const double sun_deg : {1.0, 3.0, 6.0, 9.0, 12.0}) {
      const SunDirection sun = at(sun_deg, 0.0);
      reference::ReferenceSky truth({.aerosol = aerosol_of(turbidity)}, 40.0,
                                    reference::suns_around_deg(90.0 - sun_deg));
      const SiteSky shown(DaylightModel::automatic, Turbidity{turbidity}, sun, 0.0),
          preetham(DaylightModel::preetham, Turbidity{turbidity}, sun, 0.0);
      std::vector<std::array<glm::dvec3, 3>> lights;
      std::array<double, 3> mean{};
      for (const double elevation : {2.0, 8.0, 20.0, 40.0, 65.0, 88.0})
        for (const double azimuth : {15.0, 50.0, 90.0, 135.0, 180.0}) {
          const Direction view = at(elevation, azimuth);
          lights.push_back({truth.xyz({0.0, view, sun}), shown.relative_xyz(view), preetham.relative_xyz(view)});
          for (std::size_t i = 0; i < 3; ++i) mean[i] += lights.back()[i].y;
        }
      // The exposure follows the sky: each in units of its own mean.
      std::array<double, 2> difference{};
      for (const auto& light : lights) {
        const auto lab = [&](std::size_t i) {
          return lab_of(light[i] * static_cast<double>(lights.size()) / mean[i], 5.0);
        };
        for (std::size_t i = 0; i < 2; ++i)
          difference[i] += ciede2000(lab(0), lab(i + 1)) / static_cast<double>(lights.size());
      }
      fmt::print("  {:.1f}  {:4.0f}  {:5.2f}  {:5.2f}\n", turbidity, sun_deg, difference[1], difference[0]);
      sum += difference[0];
      sum_preetham += difference[1];
      ++count;
    }
  fmt::print("suns of 1 to 12 deg: Preetham's {:.2f}, the program's {:.2f} (goal 2)\n", sum_preetham / count,
             sum / count);
  figure_row("given-light", {"sky under suns 1 to 12 deg high, CIEDE2000", figure_text(sum / count, 2), "2",
                             "`test_air_truth_light`"});
  EXPECT_LE(sum / count, 2.0);
}

}  // namespace
}  // namespace kasumi
