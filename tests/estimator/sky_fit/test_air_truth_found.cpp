// The aerosol found from readings of skies whose aerosol is known: the row's figure next to its goal. What a fit could
// know at best is in test_sky_fit_bounds.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky_fit/unknown_camera.hpp"
#include "fixtures/aerosol/kinds.hpp"
#include "fixtures/atmosphere/optics.hpp"
#include "tests/estimator/sky_fit/skies_as_readings.hpp"
#include "tests/estimator/sky_fit/strange_skies.hpp"
#include "tests/figures.hpp"
#include "tests/fixtures/atmosphere/sky_table.hpp"

namespace kasumi::test {
namespace {

ModelToFit every_model(double altitude_m) {
  ModelToFit sky{DaylightModel::automatic, altitude_m};
  sky.every_model = true;
  return sky;
}

double sigma_aod(const SkyFit& fit) {
  return std::sqrt(fit.found.covariance.aod_550);
}

// Those of one exponent differ in what they absorb alone.
bool differ_in_absorption_alone(AerosolKind a, AerosolKind b) {
  return std::abs(natural_exponent(a) - natural_exponent(b)) < 0.05;
}

// Errors over some skies.
struct Tally {
  int skies = 0, near_enough = 0, right_kind = 0, right_but_absorption = 0, papers = 0;
  int with_exponent = 0, near_exponent = 0;
  double squares = 0.0, bias = 0.0, chi = 0.0, worst = 0.0, exponent_squares = 0.0, exponent_chi = 0.0;

  void add(const SkyFit& fit, const Aerosol& truth, const std::string& told = "") {
    const double error = fit.found.aerosol.aod_550 - truth.aod_550, allowed = std::max(0.02, 0.05 * truth.aod_550);
    const double tilt = fit.found.aerosol.angstrom_exponent - truth.angstrom_exponent;
    ++skies;
    if (!told.empty() && std::abs(error) > allowed)
      fmt::print("{}, {}: {:.3f} is called {:.3f} +- {:.3f} ({}, left {:.1f} %)\n", told, name_of(truth.kind),
                 truth.aod_550, fit.found.aerosol.aod_550, sigma_aod(fit), name_of(fit.found.aerosol.kind),
                 100.0 * fit.log_residual);
    near_enough += std::abs(error) <= allowed;
    right_kind += fit.found.aerosol.kind == truth.kind;
    right_but_absorption += differ_in_absorption_alone(fit.found.aerosol.kind, truth.kind);
    papers += fit.found.papers_share > 0.5;
    squares += error * error;
    bias += error;
    chi += error * error / fit.found.covariance.aod_550;
    worst = std::max(worst, std::abs(error) / allowed);
    if (truth.aod_550 <= 0.1) return;
    ++with_exponent;
    near_exponent += std::abs(tilt) <= 0.2;
    exponent_squares += tilt * tilt;
    exponent_chi += tilt * tilt / fit.found.covariance.angstrom_exponent;
  }
  void print(const std::string& name) const {
    const double n = skies, e = std::max(1, with_exponent);
    fmt::print(
        "| {} | {} | {:.4f}, {:+.4f} | {} of {}, worst {:.2f} of it | {:.2f} | {:.2f}; {} of {} | {:.2f} | {} ({}) of "
        "{} |\n",
        name, skies, std::sqrt(squares / n), bias / n, near_enough, skies, worst, chi / n,
        std::sqrt(exponent_squares / e), near_exponent, with_exponent, exponent_chi / e, right_kind,
        right_but_absorption, skies);
  }
};
void print_head(const char* what) {
  fmt::print(
      "\n| {} | skies | AOD off: rms, mean | within .02 or 5 % | chi^2 of it | exponent off: rms; within .2 where AOD "
      "> .1 | chi^2 of it | kind right (but for absorption) |\n",
      what);
}

TEST(AirTruthFound, SpectralSkiesOfEachKind) {
  const auto zeniths_deg = figure_cases<double>("suns", {35.0, 62.0}, {15.0, 35.0, 50.0, 62.0, 70.0});
  const auto turbidities = figure_cases<double>("amounts", {1.2, 4.0, 8.0}, {1.2, 2.0, 4.0, 6.0, 8.0});
  print_head("spectral atmosphere, T");
  Tally all;
  for (const double t : turbidities) {
    Tally row;
    for (const AerosolKind kind : kAerosolKinds)
      for (const double zenith_deg : zeniths_deg) {
        const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(40.0));
        const Aerosol aerosol = aerosol_of(t, natural_exponent(kind), kind);
        const SkyFit fit = fit_sky(readings_of(spread_directions(sun), spectral_sky({.aerosol = aerosol}, 0.0, sun)),
                                   sun, every_model(0.0), {});
        row.add(fit, aerosol, fmt::format("T {}, sun {} deg from the zenith", t, zenith_deg));
        all.add(fit, aerosol);
        EXPECT_LT(fit.found.papers_share, 0.01);
      }
    row.print(fmt::format("{}", t));
  }
  all.print("all");
  fmt::print("goals: all within; kind right in 90 %; exponent within .2\n");
  const std::string skies = fmt::format("{} skies, T 1.2 to 8, seven kinds", all.skies);
  figure_row("found-simulated", {skies + ": optical depth within .02 or 5 %",
                                 fmt::format("{} of {}", all.near_enough, all.skies), "all", "`test_air_truth_found`"});
  figure_row("found-simulated", {skies + ": kind right", fmt::format("{} of {}", all.right_kind, all.skies), ">= 90 %",
                                 "`test_air_truth_found`"});
  figure_row("found-simulated",
             {skies + ": exponent within .2, where the depth is over .1",
              fmt::format("{} of {}", all.near_exponent, all.with_exponent), "all", "`test_air_truth_found`"});
  EXPECT_GE(all.near_enough, 0.95 * all.skies);
  EXPECT_LT(all.worst, 2.0);  // the goal, 1, is missed by six of 175: dust, and suns 15 deg from the zenith
  EXPECT_GE(all.near_exponent, 0.95 * all.with_exponent);
  EXPECT_GE(all.right_kind, 0.9 * all.skies);
  EXPECT_LT(all.chi / all.skies, 2.0);
}

Tally found_in(const std::map<std::string, std::vector<StrangeSky>>& sorts) {
  Tally all;
  for (const auto& [name, skies] : sorts) {
    Tally row;
    for (const StrangeSky& sky : skies) {
      const SkyFit fit = fit_sky(sky.readings, sky.sun, every_model(sky.altitude_m), sky.doubt);
      row.add(fit, sky.aerosol);
      all.add(fit, sky.aerosol);
    }
    row.print(name);
  }
  all.print("all");
  return all;
}

TEST(AirTruthFound, SkiesOfNoKindOfOurs) {
  print_head("sky, on which the sigmas were set");
  const Tally all = found_in(strange_skies(whole_figures() ? StrangeSet::developed : StrangeSet::developed_few));
  EXPECT_LT(all.chi / all.skies, 2.0);
  EXPECT_GT(all.chi / all.skies, 0.1);  // sigma was made for what differs more (test_air_truth_particles.cpp)
}

TEST(AirTruthFound, HeldOutSkies) {
  print_head("held out");
  const Tally all = found_in(strange_skies(whole_figures() ? StrangeSet::held_out : StrangeSet::held_out_few));
  EXPECT_LT(all.chi / all.skies, 2.0);
}

// Those skies, and the measured ones of Cornell, as a strange camera's pictures would have them: contrasts to a power,
// light lost towards the rim, other colours, nothing near the sun. What is asked is whether the sigmas hold the truth.
TEST(AirTruthFound, SkiesByCamerasOfWhichNothingIsKnown) {
  struct Instrument {
    double exponent, rim_loss, log_red;
  };
  const std::vector<Instrument> instruments{{0.8, 0.0, 0.1}, {1.0, 0.3, 0.0}, {1.25, 0.15, -0.1}, {1.6, 0.4, 0.05}};
  int skies = 0, told = 0, covered = 0, tones = 0;
  const auto ask = [&](std::vector<SkyReading> readings, const SunDirection& sun, double altitude_m, double aod,
                       double sigma_known, const Instrument& instrument) {
    std::erase_if(readings, [&](const SkyReading& r) { return angle_between(r.direction, sun) < from_degrees(15.0); });
    for (SkyReading& reading : readings) {
      const double loss = instrument.rim_loss * reading.off_axis * reading.off_axis;
      reading.light *= glm::exp(glm::dvec3(instrument.log_red - loss, -loss, -loss));
      reading.light = glm::pow(reading.light, glm::dvec3(instrument.exponent));
    }
    const auto fit = fit_unknown_camera(readings, sun, every_model(altitude_m));
    ++skies;
    const double found = fit.sky.found.aerosol.aod_550, sigma = std::sqrt(fit.sky.found.covariance.aod_550);
    if (!fit.sky.solved || (sigma > 0.2 && sigma > found)) return;
    ++told;
    covered += std::abs(found - aod) <= 2.0 * std::hypot(sigma, sigma_known);
    tones += std::abs(fit.exponent - instrument.exponent) <= 2.0 * fit.sigma_exponent;
  };
  const auto row = [&](const char* what) {
    fmt::print("{}: told {} of {}; within 2 sigma {}; tone exponent within 2 sigma {}\n", what, told, skies, covered,
               tones);
    figure_row("strange-air", {what, fmt::format("{} of {}", told, skies), fmt::format("{} of {}", covered, told),
                               ">= 95 %", fmt::format("{} of {}", tones, told)});
    EXPECT_GE(told, 0.9 * skies);
    EXPECT_GE(covered, 0.9 * told);
    skies = told = covered = tones = 0;
  };
  for (const auto& [name, some] : strange_skies(whole_figures() ? StrangeSet::held_out : StrangeSet::held_out_few))
    for (const StrangeSky& sky : some)
      for (const Instrument& instrument : instruments)
        ask(sky.readings, sky.sun, sky.altitude_m, sky.aerosol.aod_550, 0.0, instrument);
  row("spectral skies of no kind of ours");
  const double above = std::exp(-reference::kCornellAltitude_m / kAerosolHeight_m);
  for (const auto& sky : reference::cornell_skies())
    for (const Instrument& instrument : instruments)
      ask(readings_of(sky), sky.sun, reference::kCornellAltitude_m, (sky.in_may() ? 0.09 : 0.045) / above,
          (sky.in_may() ? 0.03 : 0.015) / above, instrument);
  if (skies > 0) row("ten measured skies, Cornell");
}

TEST(AirTruthFound, PreethamsOwnSkiesStayHis) {
  const auto turbidities =
      figure_cases<double>("turbidities", {1.9, 2.4, 7.0}, {1.8, 1.9, 2.4, 3.1, 4.0, 5.5, 7.0, 9.0});
  double worst = 0.0;
  fmt::print("\n| Preetham's T | T found at suns 25, 45, 65 deg from the zenith | least share of his model |\n");
  for (const double t : turbidities) {
    std::string found;
    double share = 1.0;
    for (const double zenith_deg : {25.0, 45.0, 65.0}) {
      const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(40.0));
      const PreethamSky sky(Turbidity{t}, sun);
      const auto light = [&](const Direction& d) { return xyz_to_linear_srgb() * sky.xyz(d); };
      const SkyFit fit = fit_sky(readings_of(spread_directions(sun), light), sun, every_model(0.0), {});
      found += fmt::format(" {:.3f} +- {:.3f}", fit.turbidity.value, fit.sigma_turbidity);
      share = std::min(share, fit.found.papers_share);
      worst = std::max(worst, std::abs(fit.turbidity.value - t));
      EXPECT_NEAR(fit.turbidity.value, t, 0.02);
      EXPECT_GT(fit.found.papers_share, 0.99);
    }
    fmt::print("| {} |{} | {:.4f} |\n", t, found, share);
  }
  fmt::print("goals: within .02; more than .99\n");
  figure_row("found-preetham", {"T of clear skies as readings, worst error, T 1.8 to 9", figure_text(worst, 3), ".02",
                                "`test_air_truth_found`"});
}

class MeasuredSkiesFound : public testing::Test {
 protected:
  void SetUp() override {
    if (skies_.empty()) GTEST_SKIP() << "no measured skies in shared/data/sky/cornell";
  }
  const std::vector<reference::MeasuredSky> skies_ = reference::cornell_skies();
};

glm::dvec2 chromaticity(const glm::dvec3& linear_srgb) {
  const glm::dvec3 xyz = srgb_to_xyz() * linear_srgb;
  return glm::dvec2(xyz) / (xyz.x + xyz.y + xyz.z);
}

// Of x, y against the dome with the aerosol found; one gain per channel is free.
double chromaticity_rms(const std::vector<SkyReading>& readings, const Direction& sun, const Aerosol& aerosol) {
  const DomeFunction sky = in_space(dome(reference::kCornellAltitude_m, aerosol, sun), xyz_to_linear_srgb());
  glm::dvec3 gain{0.0};
  for (const SkyReading& reading : readings)
    gain += glm::log(reading.light / dome_light(sky, reading.direction)) / static_cast<double>(readings.size());
  double sum = 0.0;
  for (const SkyReading& reading : readings) {
    const glm::dvec2 off =
        chromaticity(reading.light) - chromaticity(glm::exp(gain) * dome_light(sky, reading.direction));
    sum += glm::dot(off, off) / static_cast<double>(readings.size());
  }
  return std::sqrt(sum);
}

// Of a blend as well; `nm`'s share of the depth that the other kind has.
double share_of_other(const Aerosol& aerosol, double nm) {
  const double one = (1.0 - aerosol.other_share) * reference::extinction_ratio(aerosol.kind, nm),
               other = aerosol.other_share * reference::extinction_ratio(aerosol.other, nm);
  return other / (one + other);
}
reference::AerosolShape shape_of_blend(const Aerosol& aerosol) {
  const auto one = reference::shape_of(aerosol.kind), other = reference::shape_of(aerosol.other);
  const auto albedo = [aerosol, one, other](double nm) {
    return std::lerp(one.albedo(nm), other.albedo(nm), share_of_other(aerosol, nm));
  };
  return {albedo, [aerosol, one, other, albedo](double nm) {
            const double t = share_of_other(aerosol, nm) * other.albedo(nm) / albedo(nm);
            const auto p = one.phase(nm), q = other.phase(nm);
            reference::PhaseCurve both;
            both.value = [t, p, q](double cosine) { return std::lerp(p.value(cosine), q.value(cosine), t); };
            for (std::size_t l = 0; l < both.moments.size(); ++l)
              both.moments[l] = std::lerp(p.moments[l], q.moments[l], t);
            return both;
          }};
}
double depth_of_blend(const Aerosol& aerosol, double nm) {
  const double ratio = std::lerp(reference::extinction_ratio(aerosol.kind, nm),
                                 reference::extinction_ratio(aerosol.other, nm), aerosol.other_share);
  const double tilt = aerosol.angstrom_exponent - natural_exponent(aerosol.kind, aerosol.other, aerosol.other_share);
  return aerosol.aod_550 * ratio * std::pow(nm / 550.0, -tilt);
}

// Of ln L from 440 to 680 nm against the spectral atmosphere with the aerosol found, nothing fitted but a gain per
// wavelength.
double spectral_rms(const reference::MeasuredSky& sky, std::size_t index, const reference::SkyTable& table,
                    const Aerosol& aerosol) {
  double squares = 0.0;
  for (std::size_t w = 0; w < reference::kFitted_nm.size(); ++w) {
    const double nm = reference::kFitted_nm[w], depth = depth_of_blend(aerosol, nm);
    const auto measured = static_cast<std::size_t>(std::lround((nm - sky.wavelengths_nm.front()) / 10.0));
    double sum = 0.0, sum_of_squares = 0.0;
    for (std::size_t d = 0; d < sky.directions.size(); ++d) {
      const double off = std::log(sky.light[d][measured]) - table.log_light(index, d, w, depth);
      sum += off;
      sum_of_squares += off * off;
    }
    const auto n = static_cast<double>(sky.directions.size());
    squares += sum_of_squares / n - sum * sum / (n * n);
  }
  return std::sqrt(squares / static_cast<double>(reference::kFitted_nm.size()));
}

TEST_F(MeasuredSkiesFound, TellTheTwoDaysApart) {
  std::vector<SkyFit> fits;
  double ground = 0.0;
  for (const auto& sky : skies_) {
    fits.push_back(fit_sky(readings_of(sky), sky.sun, every_model(reference::kCornellAltitude_m), kScanner));
    ASSERT_TRUE(fits.back().solved);
    ground += fits.back().models.front().ground_albedo / static_cast<double>(skies_.size());
  }
  double may = 0.0, september = 0.0, chi = 0.0, may_spectral = 0.0, worst_colour = 0.0;
  double may_sigma = 0.0, september_sigma = 0.0;
  int in_may = 0, as_known = 0;
  fmt::print(
      "\n| scan | AOD(550), sigma | what was | chi^2 | exponent | kind, its probability | fit's rms | ln L 440-680 nm, "
      "x y with the aerosol found |\n");
  for (std::size_t s = 0; s < skies_.size(); ++s) {
    const auto& sky = skies_[s];
    const std::vector<SkyReading> readings = readings_of(sky);
    const SkyFit& fit = fits[s];
    // What is known of both days is the depth above the site.
    const double above = std::exp(-reference::kCornellAltitude_m / kAerosolHeight_m),
                 aod = above * fit.found.aerosol.aod_550, sigma = above * sigma_aod(fit),
                 known = sky.in_may() ? 0.09 : 0.045, sigma_known = sky.in_may() ? 0.03 : 0.015;
    const double off = (aod - known) / std::hypot(sigma, sigma_known);
    const Aerosol& best = fit.models.front().aerosol;
    const reference::SkyTable table({sky}, shape_of_blend(best), ground);
    const double spectral = spectral_rms(sky, 0, table, best), colour = chromaticity_rms(readings, sky.sun, best);
    fmt::print(
        "| {} | {:.3f} +- {:.3f} | {} +- {} | {:.2f} | {:.2f} +- {:.2f} | {}, {:.2f} | {:.1f} % | {:.1f} %, {:.4f} |\n",
        sky.utc, aod, sigma, known, sigma_known, off * off, fit.found.aerosol.angstrom_exponent,
        std::sqrt(fit.found.covariance.angstrom_exponent), name_of(best.kind), fit.models.front().answer.weight,
        100.0 * fit.log_residual, 100.0 * spectral, colour);
    chi += off * off / static_cast<double>(skies_.size());
    as_known += std::abs(aod - known) <= sigma_known;
    (sky.in_may() ? may : september) += aod;
    (sky.in_may() ? may_sigma : september_sigma) += sigma;
    if (sky.in_may()) {
      ++in_may;
      may_spectral += spectral;
    }
    worst_colour = std::max(worst_colour, colour);
    EXPECT_LT(fit.found.papers_share, 0.5);
    EXPECT_LT(colour, 0.012);
  }
  may /= in_may;
  may_spectral /= in_may;
  const double in_september = static_cast<double>(skies_.size()) - in_may;
  september /= in_september;
  const auto row = [](const char* what, const std::string& found, const char* goal) {
    figure_row("found-measured", {what, found, goal, "`test_air_truth_found`"});
  };
  row("Kider's May, spectra: optical depth, sigma", figure_text(may, 3) + ", " + figure_text(may_sigma / in_may, 3),
      ".09 +- .03: known");
  row("September: optical depth, sigma",
      figure_text(september, 3) + ", " + figure_text(september_sigma / in_september, 3), ".045 +- .015: known");
  row("the days apart", figure_text(may - september, 3), ">= .025");
  row("of the ten, within what is known of their day", fmt::format("{} of {}", as_known, skies_.size()), "all");
  row("rms of ln L, 440 to 680 nm, a gain per wavelength, May", fmt::format("{:.1f} %", 100.0 * may_spectral), "7 %");
  row("chromaticity, rms of the worst scan", figure_text(worst_colour, 4), ".010");
  row("chi^2 a scan", figure_text(chi, 2), ".5 to 2");
  fmt::print(
      "May {:.3f} (.09 +- .03), September {:.3f} (.045 +- .015), apart {:.3f} (goal .025); within what is known {} of "
      "{}; chi^2 per scan {:.2f} (goal .5 to 2); ground {:.2f}; ln L in May {:.1f} % (goal 7); chromaticity at worst "
      "{:.4f} (goal .010)\n",
      may, september, may - september, as_known, skies_.size(), chi, ground, 100.0 * may_spectral, worst_colour);
  EXPECT_NEAR(may, 0.09, 0.03);
  EXPECT_NEAR(september, 0.045, 0.015);
  EXPECT_GT(may - september, 0.025);
  EXPECT_LT(chi, 2.0);
}

}  // namespace
}  // namespace kasumi::test
