#include <algorithm>

#include <fmt/format.h>

#include "pipeline/site/files/contact_sheet.hpp"
#include "tests/figures.hpp"
#include "tests/paper/methods.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

constexpr double kSourceTurbidity = 1.9, kTargetTurbidities[] = {2.11, 2.54, 2.94, 4.36};  // M Sect 7.2.3

struct Given {
  std::string name;
  Place place;
};

// Sums over scenes and turbidities of each method's results.
struct Reached {
  std::map<Method, std::vector<Judged>> by_method;
  std::map<Method, std::vector<double>> turbidity;
};

std::string text_of(const Judged& one) {
  return fmt::format("{:.4f} / {:.3f}", one.ssim, one.colour.combined());
}

// Pictures in which M as printed is not above a baseline.
struct Lost {
  int structure = 0, colour = 0;
};

bool baseline(Method method) {
  return method == Method::he || method == Method::zhu || method == Method::zhao;
}

void show(Section& section, const Given& given, const Scene& source, const Experiment& experiment,
          const std::vector<Judged>& judged, double turbidity) {
  ContactSheet sheet;
  sheet.add(source.picture, fmt::format("source, T {}", kSourceTurbidity));
  sheet.add(experiment.truth, fmt::format("truth, T {}", turbidity));
  for (const auto& one : judged)
    if (one.method != Method::untouched) sheet.add(one.picture, std::string(name_of(one.method)));
  section.picture(sheet.drawn(3), fmt::format("M Fig 12, {}: T {} to {}", given.name, kSourceTurbidity, turbidity),
                  1000);
}

}  // namespace

Section scenes_section(const ReportOptions& options) {
  Section section("scenes", "Other air on generated scenes: M Fig 12 and 13, M14 Fig 8");
  section.say(
      "M's turbidities, T 1.9 made into 2.11, 2.54, 2.94 and 4.36, on generated scenes whose distances and true "
      "pictures are known (spectra in steps of 1 nm; 8 bits with a camera's noise in both pictures). SSIM as Wang "
      "2004; HSV correlation as M Eq 27, mean of hue, saturation and value (30, 32, 32 bins). 'Another shot' is the "
      "true picture with other noise: no method can be expected to be closer than that.");
  section.say(
      "All are given the light from infinity of both pictures, as measured at their horizons, and the sky's outline. "
      "Kasumi, M and Zhao: distances and both T. Zhao 2012, a thesis that is not public: M's equation with Preetham's "
      "coefficients times .01, as M and M14 describe it. He 2011 and Zhu 2015: their transmission from the one picture "
      "with its guided filter, then as many times the haze as comes nearest to the true picture, in encoded values or "
      "in linear light, for each measure by itself: more than anybody could know. 'M as printed' keeps rho (Eq 25), "
      "Kasumi lets the light on the land change with the air, sun and shade apart, and does not amplify noise. The "
      "scenes are of Preetham's world, whose haze is M's own: they show how well each method carries that haze over, "
      "not whether real air is so.");
  std::vector<Given> places{{"sun 40 deg high", {}},
                            {"sun 55 deg high", {.terrain = 5, .sun_zenith_deg = 35.0, .sun_azimuth_deg = 300.0}},
                            {"sun 25 deg high", {.terrain = 7, .sun_zenith_deg = 65.0, .sun_azimuth_deg = 110.0}}};
  if (options.quick) {
    places.resize(1);
    places.front().place.width = 240;
    places.front().place.height = 136;
  }
  std::map<Method, Series> structure, colours;
  for (const Method method : kMethods)
    structure[method] =
        colours[method] = {.name = std::string(name_of(method)), .marks = true, .dashed = method == Method::untouched};
  int won = 0, compared = 0, pictures = 0;
  std::map<Method, Lost> lost_by_printed;
  double least_colour_lead = 1.0, least_structure_lead = 1.0;
  std::string lost;
  for (const auto& given : places) {
    const auto land = land_at(given.place);
    const auto source = scene_at(land, kSourceTurbidity, 31);
    std::vector<std::vector<std::string>> rows;
    for (const double turbidity : kTargetTurbidities) {
      if (options.quick && (turbidity < 2.5 || (turbidity > 2.9 && turbidity < 4.0))) continue;
      const auto target = scene_at(land, turbidity, 32), again = scene_at(land, turbidity, 33);
      const auto experiment = experiment_of(source, kSourceTurbidity, target, turbidity);
      const auto judged = judge_methods(experiment);
      std::vector<std::string> row{fmt::format("{}", turbidity)};
      const auto& printed = *std::ranges::find(judged, Method::morales, &Judged::method);
      ++pictures;
      for (const auto& one : judged) {
        if (baseline(one.method)) {
          lost_by_printed[one.method].structure += !(printed.ssim > one.ssim);
          lost_by_printed[one.method].colour += !(printed.colour.combined() > one.colour.combined());
        }
        row.push_back(text_of(one));
        if (&given == &places.front()) {
          structure[one.method].points.emplace_back(turbidity, one.ssim);
          colours[one.method].points.emplace_back(turbidity, one.colour.combined());
        }
        if (!baseline(one.method)) continue;
        const double lead = judged.front().ssim - one.ssim,
                     colour_lead = judged.front().colour.combined() - one.colour.combined();
        compared += 2;
        won += (lead > 0.0) + (colour_lead > 0.0);
        least_structure_lead = std::min(least_structure_lead, lead);
        least_colour_lead = std::min(least_colour_lead, colour_lead);
        if (!(lead > 0.0))
          lost += fmt::format("{}{} at T {}, {} (by {:.4f})", lost.empty() ? "" : "; ", name_of(one.method), turbidity,
                              given.name, -lead);
      }
      row.push_back(fmt::format("{:.4f} / {:.3f}", ssim(again.picture, target.picture),
                                hsv_correlation(again.picture, target.picture).combined()));
      if (&given == &places.front()) {
        std::vector<std::string> cells{row.front()};
        const auto add = [&](double alike, double colour) {
          cells.push_back(figure_text(alike, 4) + ", " + figure_text(colour, 3));
        };
        for (const auto& one : judged)
          if (one.method != Method::untouched) add(one.ssim, one.colour.combined());
        add(ssim(again.picture, target.picture), hsv_correlation(again.picture, target.picture).combined());
        figure_row("papers-methods", cells);
      }
      rows.push_back(std::move(row));
      if (turbidity > 4.0) show(section, given, source, experiment, judged, turbidity);
    }
    std::vector<std::string> head{given.name + ": T"};
    for (const Method method : kMethods) head.emplace_back(name_of(method));
    head.emplace_back("another shot");
    section.table(head, rows);
  }
  const auto plot = [&](const char* title, const char* up, const std::map<Method, Series>& curves) {
    Plot made{.title = title, .across = "target turbidity (source: 1.9)", .up = up};
    for (const auto& [method, series] : curves) made.series.push_back(series);
    section.plot(made);
  };
  plot("M Fig 13: structural similarity, first scene", "SSIM", structure);
  plot("M Fig 13: combined HSV histogram correlation, first scene", "correlation", colours);
  section.figure("comparisons", compared);
  section.figure("won", won);
  section.figure("least_ssim_lead", least_structure_lead);
  section.figure("least_colour_lead", least_colour_lead);
  // M's own words: above all three in both measures, but for He's SSIM at the least hazy of four.
  int structure_lost = 0, colour_lost = 0;
  std::string to_whom;
  for (const auto& [method, of] : lost_by_printed) {
    structure_lost += of.structure;
    colour_lost += of.colour;
    to_whom += fmt::format("{}{} in {} of {}", to_whom.empty() ? "" : ", ", name_of(method), of.structure, pictures);
    section.figure(fmt::format("ssim_lost_by_printed_to_{}", name_of(method)), of.structure);
  }
  section.figure("colour_lost_by_printed", colour_lost);
  section.finding(
      4 * structure_lost <= pictures && colour_lost == 0 ? Finding::reproduced : Finding::differs,
      fmt::format("M as printed (Eq 26) is not above in SSIM: {}; in colour in {} of {} comparisons. M says that it is "
                  "above all three, but for He's SSIM at T 2.11 (its Fig 13 is a picture without numbers). "
                  "The baselines have the haze that comes nearest to the true picture, which M's may not have had.",
                  to_whom, colour_lost, 3 * pictures));
  section.finding(
      won == compared ? Finding::better : Finding::differs,
      fmt::format(
          "our extension, whose light on the land changes with the air and which does not amplify noise, is "
          "above the three in {} of {} comparisons, in SSIM by at least {:.4f}, in colour by at least {:.3f}.{}",
          won, compared, least_structure_lead, least_colour_lead,
          lost.empty() ? "" : " Not above in SSIM: " + lost + "."));
  return section;
}

}  // namespace kasumi::paper
