#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "pipeline/site/files/contact_sheet.hpp"
#include "tests/paper/methods.hpp"
#include "tests/paper/report/section.hpp"
#include "tests/paper/single_image.hpp"

namespace kasumi::paper {
namespace {

// What reaches the camera from the land, and what the air before it adds (M Fig 3); linear light.
struct Terms {
  Image<glm::vec3> direct, air;
};

template <class Transmission>
Terms terms_of(const Experiment& given, const Image<glm::vec3>& light, Transmission transmission) {
  Terms terms{light, Image<glm::vec3>(light.width(), light.height())};
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      if (given.depth.distance_m.at(x, y) <= 0.0F) continue;  // the sky is cut out, as M cuts it out
      const glm::dvec3 air = glm::dvec3(given.source.of(x, y)) * (1.0 - transmission(x, y));
      terms.air.at(x, y) = air;
      terms.direct.at(x, y) = glm::max(glm::dvec3(0.0), glm::dvec3(light.at(x, y)) - air);
    }
  return terms;
}

Terms by_distance(const Experiment& given, const Image<glm::vec3>& light, ScatteringModel model) {
  const auto haze =
      haze_coefficients(attenuation_nodes(spectral_measure(given.camera)), model, given.source.state->turbidity());
  return terms_of(given, light, [&](int x, int y) { return attenuation(haze, given.depth.path(x, y)); });
}

Terms by_picture(const Experiment& given, const Image<glm::vec3>& light, Method method) {
  Image<glm::vec3> relative(light.width(), light.height()), values = relative;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      relative.at(x, y) = light.at(x, y) / glm::max(given.source.of(x, y), 1e-6F);
      values.at(x, y) = glm::vec3(given.picture.at(x, y)) / 255.0F;
    }
  const auto found =
      method == Method::he ? transmission_by_dark_channel(relative, values) : transmission_by_colour(values);
  return terms_of(given, light, [&](int x, int y) { return glm::dvec3(static_cast<double>(found.at(x, y))); });
}

Image<Rgb8> shown(const Camera& camera, const Image<glm::vec3>& light) {
  Image<Rgb8> picture(light.width(), light.height());
  for (std::size_t i = 0; i < light.elements().size(); ++i)
    picture.elements()[i] = Rgb8(glm::round(
        255.0 * glm::clamp(camera.response.to_encoded(glm::dvec3(light.elements()[i])), glm::dvec3(0), glm::dvec3(1))));
  return picture;
}

double mean_of_land(const Experiment& given, const Image<glm::vec3>& light) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < light.elements().size(); ++i) {
    if (given.depth.distance_m.elements()[i] <= 0.0F) continue;
    sum += static_cast<double>(light.elements()[i].g);
    ++count;
  }
  return sum / std::max(1, count);
}

// How much of the land's pattern is left in the airlight: correlation of the two among pixels of about one distance
// (within 5 %). Airlight that is a function of the distance alone has none.
double pattern_left(const Experiment& given, const Image<glm::vec3>& air, const Image<glm::vec3>& light) {
  struct Sums {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  };
  std::map<int, Sums> bins;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const auto distance_m = static_cast<double>(given.depth.distance_m.at(x, y));
      if (distance_m <= 0.0) continue;
      const auto infinite = static_cast<double>(given.source.of(x, y).g);
      const double a = static_cast<double>(air.at(x, y).g) / infinite,
                   b = static_cast<double>(light.at(x, y).g) / infinite;
      auto& sums = bins[static_cast<int>(std::lround(std::log(distance_m) / 0.05))];
      sums.n += 1;
      sums.a += a;
      sums.b += b;
      sums.aa += a * a;
      sums.bb += b * b;
      sums.ab += a * b;
    }
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (const auto& [bin, s] : bins) {
    if (s.n < 8) continue;
    aa += s.aa - s.a * s.a / s.n;
    bb += s.bb - s.b * s.b / s.n;
    ab += s.ab - s.a * s.b / s.n;
  }
  return ab / std::sqrt(std::max(1e-12, aa * bb));
}

// M14 Fig 10: other air over the whole scene but its sky, by M's coefficients and by Zhao's.
void figure_10_of_2014(Section& section, const Scene& scene, double turbidity) {
  const auto given = experiment_of(scene, turbidity, scene, turbidity);
  const auto nodes = attenuation_nodes(spectral_measure(given.camera));
  ContactSheet sheet;
  sheet.add(given.picture, fmt::format("as taken, T {}", turbidity));
  sheet.add(shown(given.camera,
                  retarget(scene.light, given.depth, given.source, {{}, given.source.from_infinity}, nodes).light),
            "without air");
  const double infinite =
      mean_of_land(given, Image<glm::vec3>(scene.light.width(), scene.light.height(), glm::vec3(1)));
  std::map<ScatteringModel, double> left;
  for (const double target : {3.0, 7.0, 15.0})
    for (const auto model : {ScatteringModel::morales2017, ScatteringModel::zhao}) {
      RetargetLimits options;
      options.scattering = model;
      const auto made = retarget(scene.light, given.depth, given.source,
                                 {Turbidity{target}, given.source.from_infinity}, nodes, options);
      const auto haze = haze_coefficients(nodes, model, Turbidity{target});
      Image<glm::vec3> gamma(scene.light.width(), scene.light.height());
      for (int y = 0; y < gamma.height(); ++y)
        for (int x = 0; x < gamma.width(); ++x) gamma.at(x, y) = attenuation(haze, given.depth.path(x, y));
      left[model] = mean_of_land(given, gamma) / infinite;
      sheet.add(shown(given.camera, made.light),
                fmt::format("{}, T {:g}", model == ScatteringModel::zhao ? "Zhao 2012" : "M", target));
    }
  section.picture(sheet.drawn(2), "M14 Fig 10: left by M's coefficients, right by Zhao's", 800);
  const double ours = left[ScatteringModel::morales2017], zhao = left[ScatteringModel::zhao];
  section.finding(
      zhao > ours ? Finding::reproduced : Finding::differs,
      fmt::format("M14 Fig 10: Zhao's air is the weaker: at T 15 it leaves {:.0f} % of the land's light, M's {:.0f} %.",
                  100.0 * zhao, 100.0 * ours));
}

}  // namespace

Section terms_section(const ReportOptions& options) {
  Section section("terms", "Airlight and direct transmission apart: M Fig 11, M14 Fig 7 and 10");
  section.say(
      "One generated scene at M14's turbidities, divided into what the air adds and what of the land reaches the "
      "camera, by each method's own transmission and the light from infinity at the picture's horizon. The scenes are "
      "of Preetham's world, whose haze is M's: they say what the methods do, not what air does.");
  Place place;
  if (options.quick) {
    place.width = 160;
    place.height = 90;
  }
  const auto land = land_at(place);
  std::vector<std::vector<std::string>> rows;
  std::map<std::string, double> most_pattern;
  double least_darker = 1e9, least_brighter = 1e9;
  for (const double turbidity : {1.9, 2.94, 4.36}) {
    const auto scene = scene_at(land, turbidity, 41);
    const auto given = experiment_of(scene, turbidity, scene, turbidity);
    const std::vector<std::pair<std::string, Terms>> all{
        {"M, Kasumi", by_distance(given, scene.light, ScatteringModel::morales2017)},
        {"Zhao 2012", by_distance(given, scene.light, ScatteringModel::zhao)},
        {"He 2011", by_picture(given, scene.light, Method::he)},
        {"Zhu 2015", by_picture(given, scene.light, Method::zhu)}};
    if (turbidity < 2.0) figure_10_of_2014(section, scene, turbidity);
    ContactSheet sheet;
    for (const auto& [name, terms] : all) {
      const double pattern = pattern_left(given, terms.air, scene.light);
      most_pattern[name] = std::max(most_pattern[name], std::abs(pattern));
      rows.push_back({fmt::format("{}", turbidity), name, fmt::format("{:.3f}", mean_of_land(given, terms.direct)),
                      fmt::format("{:.3f}", mean_of_land(given, terms.air)), fmt::format("{:+.2f}", pattern)});
      sheet.add(shown(given.camera, terms.direct), name + ", direct transmission");
      sheet.add(shown(given.camera, terms.air), name + ", airlight");
    }
    least_darker =
        std::min(least_darker, mean_of_land(given, all[1].second.direct) / mean_of_land(given, all[0].second.direct));
    least_brighter =
        std::min(least_brighter, mean_of_land(given, all[0].second.air) / mean_of_land(given, all[1].second.air));
    section.picture(sheet.drawn(2), fmt::format("M Fig 11, M14 Fig 7: T {}", turbidity), 800);
  }
  section.table({"T", "method", "direct transmission of land, mean", "airlight before land, mean",
                 "airlight's correlation with the land at one distance"},
                rows);
  for (const auto& [name, pattern] : most_pattern) section.figure("pattern_left." + name, pattern);
  section.figure("direct_zhao_over_ours", least_darker);
  section.figure("air_ours_over_zhao", least_brighter);
  section.finding(
      least_darker > 1.0 && least_brighter > 1.0 ? Finding::reproduced : Finding::differs,
      fmt::format("M14 Fig 7: M's direct transmission is darker than Zhao's (his at least {:.2f} times as much) "
                  "and M's airlight brighter (at least {:.2f} times).",
                  least_darker, least_brighter));
  const double by_one_picture = std::min(most_pattern["He 2011"], most_pattern["Zhu 2015"]);
  section.finding(
      by_one_picture > 3.0 * most_pattern["M, Kasumi"] ? Finding::reproduced : Finding::differs,
      fmt::format("M Fig 11: airlight by one picture keeps the land's pattern (correlation at one distance: He "
                  "{:.2f}, Zhu {:.2f}), M's does not ({:.2f}).",
                  most_pattern["He 2011"], most_pattern["Zhu 2015"], most_pattern["M, Kasumi"]));
  section.finding(
      most_pattern["Zhao 2012"] > 3.0 * most_pattern["M, Kasumi"] ? Finding::reproduced : Finding::differs,
      fmt::format("M has Zhao's airlight keep the objects' colours, too; by M's own description of it, a function of "
                  "distance, it keeps {:.2f}, as M's ({:.2f}).",
                  most_pattern["Zhao 2012"], most_pattern["M, Kasumi"]));
  return section;
}

}  // namespace kasumi::paper
