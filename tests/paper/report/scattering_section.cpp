#include <cmath>

#include <fmt/format.h>

#include "estimator/air/scattering.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

constexpr double kGreen_nm = 550.0;

double per_km(ScatteringModel model, double turbidity) {
  return 1000.0 * mie_per_m(model, kGreen_nm, Turbidity{turbidity});
}

// T at which M's Mie coefficient has this value: Eq 24 inverted.
double turbidity_of_mie(double mie_per_km) {
  return 1.0 + 0.6 * mie_per_km / per_km(ScatteringModel::morales2017, 1.6);
}

void coefficients(Section& section) {
  const auto rayleigh = 1000.0 * rayleigh_per_m(ScatteringModel::morales2017, kGreen_nm);
  const double at_16 = per_km(ScatteringModel::morales2017, 1.6);
  section.say(
      "Sea level, 550 nm. M Table 2 gives the bounds of the classes; T from M Eq 24, V = 3.912 / (beta_R + "
      "beta_M) as meteorologists have it.");
  struct Bound {
    const char* name;
    double mie_per_km;
  };
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, mie] : {Bound{"exceptionally clear", 0.0639}, Bound{"very clear", 0.1819},
                                  Bound{"clear", 0.3769}, Bound{"light haze", 0.9399}, Bound{"haze", 1.9459}})
    rows.push_back({name, fmt::format("{:.4f}", mie), fmt::format("{:.2f}", turbidity_of_mie(mie)),
                    fmt::format("{:.1f} km", 3.912 / (rayleigh + mie))});
  section.table({"weather, up to", "beta_M, 1/km (M Table 2)", "T", "visibility"}, rows);
  section.table({"", "paper", "recomputed", ""},
                {{"beta_R, 1/km", "0.0141", fmt::format("{:.4f}", rayleigh), "M Eq 14, 15, K_R = 1.0396"},
                 {"beta_R before K_R", "0.0135", fmt::format("{:.4f}", rayleigh / 1.0396),
                  "0.0141 / 0.0135 is 1.0444, not 1.0396: M divided unrounded numbers"},
                 {"beta_M at T = 1.6, 1/km", "0.0639", fmt::format("{:.4f}", at_16), "M Eq 18, K_M = .0092"},
                 {"visibility at T = 1.9", "about 20 km (M14)",
                  fmt::format("{:.1f} km", meteorological_range_m(Turbidity{1.9}, 0.0) / 1000.0),
                  fmt::format("20 km is T = {:.2f}", turbidity_of_mie(3.912 / 20.0 - rayleigh))}});
  section.figure("rayleigh_per_km", rayleigh);
  section.figure("mie_per_km_at_1.6", at_16);
  const double off = std::abs(at_16 / 0.0639 - 1.0);
  section.finding(off < 0.005 ? Finding::reproduced : Finding::differs,
                  fmt::format("beta_R {:.4f} and beta_M(1.6) {:.4f} per km: the scattering table within {:.1f} %.",
                              rayleigh, at_16, 100.0 * off));
  const double seen_km = meteorological_range_m(Turbidity{1.9}, 0.0) / 1000.0;
  section.figure("visibility_at_1.9_km", seen_km);
  section.finding(
      std::abs(seen_km / 20.0 - 1.0) < 0.1 ? Finding::reproduced : Finding::differs,
      fmt::format("M14 says that one sees some 20 km at T = 1.9; by its own coefficients it is {:.1f} km.", seen_km));
}

// M Eq 5 defines T over whole columns; M's coefficients are calibrated at the ground (M Eq 15 to 18).
void equation_5(Section& section) {
  std::vector<std::vector<std::string>> rows;
  double miss = 0.0;
  for (const double t : {1.6, 2.0, 3.0, 5.0, 9.0}) {
    const double by_ground =
        (1000.0 * rayleigh_per_m(ScatteringModel::morales2017, kGreen_nm) + per_km(ScatteringModel::morales2017, t)) /
        (1000.0 * rayleigh_per_m(ScatteringModel::morales2017, kGreen_nm));
    const double column =
        1.0 + per_km(ScatteringModel::morales2017, t) * kMieScaleHeight_m /
                  (1000.0 * rayleigh_per_m(ScatteringModel::morales2017, kGreen_nm) * kRayleighScaleHeight_m);
    miss = (column - 1.0) / (t - 1.0) - 1.0;
    rows.push_back({fmt::format("{}", t), fmt::format("{:.3f}", column), fmt::format("{:+.1f} %", 100.0 * miss),
                    fmt::format("{:.3f}", by_ground)});
  }
  section.say(
      "M Eq 5 defines T as the optical thickness of molecules and haze over that of molecules alone. M's own "
      "beta_R and beta_M (Eq 15, 18) with M's own scale heights (7994 and 1200 m), put into Eq 5:");
  section.table({"T put in", "T by Eq 5, upright through the air", "T - 1 off by", "T by Eq 5, level at sea level"},
                rows);
  section.figure("eq5_miss_percent", 100.0 * miss);
  section.finding(
      std::abs(miss) < 0.02 ? Finding::reproduced : Finding::differs,
      fmt::format("M's coefficients miss M's own definition of T (Eq 5): T - 1 comes out {:.1f} % off over a whole "
                  "column, whatever the T, since K_R and K_M are fitted to a table of coefficients at the ground.",
                  100.0 * miss));
}

void figure_9(Section& section) {
  constexpr double kTurbidity = 2.94;
  Plot plot{.title = fmt::format("M Fig 9: what is left of light at 550 nm, T = {}", kTurbidity),
            .across = "distance, km",
            .up = "attenuation factor",
            .series = {{.name = "Preetham, as M used it"},
                       {.name = "Zhao"},
                       {.name = "M (Kasumi)"},
                       {.name = "M's shorthand e^(-.0137 beta s)", .dashed = true}},
            .range_across = glm::dvec2{0.05, 50.0},
            .range_up = glm::dvec2{0.0, 1.0}};
  plot.log_across = true;
  const double preetham =
      per_km(ScatteringModel::preetham, kTurbidity) + 1000.0 * rayleigh_per_m(ScatteringModel::preetham, kGreen_nm);
  const double zhao =
      per_km(ScatteringModel::zhao, kTurbidity) + 1000.0 * rayleigh_per_m(ScatteringModel::zhao, kGreen_nm);
  const double ours = per_km(ScatteringModel::morales2017, kTurbidity) +
                      1000.0 * rayleigh_per_m(ScatteringModel::morales2017, kGreen_nm);
  for (double km = 0.05; km <= 50.0; km *= 1.1)
    for (std::size_t i = 0; i < 4; ++i) {
      const double beta = i == 0 ? preetham : i == 1 ? zhao : i == 2 ? ours : 0.0137 * preetham;
      plot.series[i].points.emplace_back(km, std::exp(-beta * km));
    }
  section.plot(plot);
  const double mie_p = per_km(ScatteringModel::preetham, kTurbidity), mie_z = per_km(ScatteringModel::zhao, kTurbidity),
               mie_m = per_km(ScatteringModel::morales2017, kTurbidity);
  section.table({"beta_M against", "M says", "recomputed, T = 2.94"},
                {{"Preetham", "70 times smaller (factor .0137)",
                  fmt::format("{:.1f} times smaller ({:.4f})", mie_p / mie_m, mie_m / mie_p)},
                 {"Zhao", "1.43 times smaller (Sect 7.2.1)", fmt::format("{:.2f} times larger", mie_m / mie_z)}});
  section.figure("morales_over_zhao", mie_m / mie_z);
  section.figure("preetham_over_morales", mie_p / mie_m);
  std::size_t between = 0;
  for (std::size_t i = 0; i < plot.series[2].points.size(); ++i) {
    const double left = plot.series[2].points[i].y;
    between += plot.series[0].points[i].y <= left && left <= plot.series[1].points[i].y;
  }
  section.finding(
      between == plot.series[2].points.size() ? Finding::reproduced : Finding::differs,
      fmt::format("M Fig 9: at {} of {} distances more is left than by Preetham's coefficients and less than "
                  "by Zhao's; at 1 km {:.4f}, {:.3f} and {:.3f}.",
                  between, plot.series[2].points.size(), std::exp(-preetham), std::exp(-ours), std::exp(-zhao)));
  section.finding(
      mie_m < mie_z ? Finding::reproduced : Finding::differs,
      fmt::format("M's text has its coefficient 1.43 times smaller than Zhao's; by the equations, and by M's own "
                  "Fig 9, it is {:.2f} times larger. And Preetham's published program carries a factor .01 for "
                  "units, which is Zhao's value: '70 times too strong' is that factor left out.",
                  mie_m / mie_z));
}

void figure_10(Section& section) {
  Plot plot{.title = "M Fig 10: scattering coefficient by turbidity, 550 nm",
            .across = "turbidity",
            .up = "beta_M, 1/km",
            .series = {{.name = "M (Kasumi)"},
                       {.name = "Zhao"},
                       {.name = "M Eq 24 from T = 1.6", .line = false, .marks = true}},
            .bands = {{"exceptionally clear", 0.0, 0.0639},
                      {"very clear", 0.0639, 0.1819},
                      {"clear", 0.1819, 0.3769},
                      {"light haze", 0.3769, 0.9399},
                      {"haze", 0.9399, 1.9459},
                      {"fog", 1.9459, 3.0}},
            .range_across = glm::dvec2{1.0, 20.0},
            .range_up = glm::dvec2{0.01, 3.0}};
  plot.log_up = true;
  for (double t = 1.05; t <= 20.0; t += 0.05) {
    plot.series[0].points.emplace_back(t, per_km(ScatteringModel::morales2017, t));
    plot.series[1].points.emplace_back(t, per_km(ScatteringModel::zhao, t));
  }
  for (int t = 2; t <= 20; ++t)
    plot.series[2].points.emplace_back(t, per_km(ScatteringModel::morales2017, 1.6) * (t - 1.0) / 0.6);
  section.plot(plot);
  // M Eq 24 is M Eq 18 written as a ratio: it holds by construction, and that is no finding.
  const double fog = turbidity_of_mie(1.9459), haze = turbidity_of_mie(0.9399);
  section.figure("fog_begins_at_turbidity", fog);
  section.finding(
      fog > 18.0 && fog < 22.0 ? Finding::reproduced : Finding::differs,
      fmt::format("M Fig 10: light haze ends at T = {:.1f}, fog begins at T = {:.1f}; M14 has fog above 20.", haze,
                  fog));
}

}  // namespace

Section scattering_section(const ReportOptions&) {
  Section section("scattering", "Scattering: M Table 2, Eq 5, Fig 9, Fig 10");
  coefficients(section);
  equation_5(section);
  figure_9(section);
  figure_10(section);
  return section;
}

}  // namespace kasumi::paper
