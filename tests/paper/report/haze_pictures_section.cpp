#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "calib/distances/distance_map.hpp"
#include "estimator/haze/haze_picture.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/paper/generated_scene.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

const glm::dvec3 kAirlight{0.8, 0.82, 0.85};  // H does not print its own

struct Pictured {
  std::string name;
  Image<glm::vec3> light;
  HazeRange range;
  Image<float> measured_m;
};

Image<Rgb8> encoded(const Image<glm::vec3>& light) {
  const Camera camera;
  Image<Rgb8> picture(light.width(), light.height());
  for (std::size_t i = 0; i < light.elements().size(); ++i)
    picture.elements()[i] = Rgb8(glm::round(
        255.0 * glm::clamp(camera.response.to_encoded(glm::dvec3(light.elements()[i])), glm::dvec3(0), glm::dvec3(1))));
  return picture;
}

// Sum of the differences between neighbours where the range lies between two of its quantiles.
double edges(const Pictured& scene, const Image<glm::vec3>& light, double from, double to) {
  double sum = 0.0;
  for (int y = 0; y + 1 < light.height(); ++y)
    for (int x = 0; x + 1 < light.width(); ++x) {
      const auto range = static_cast<double>(scene.range.range.at(x, y));
      if (range < from || range > to) continue;
      const auto g = light.at(x, y).g;
      sum += static_cast<double>(std::abs(light.at(x + 1, y).g - g) + std::abs(light.at(x, y + 1).g - g));
    }
  return sum;
}

std::pair<double, double> nearest_and_farthest(const Pictured& scene) {
  auto ranges = scene.range.range.elements();
  std::ranges::sort(ranges);
  return {static_cast<double>(ranges[ranges.size() / 10]), static_cast<double>(ranges[ranges.size() * 7 / 10])};
}

struct Blurred {
  double near = 1.0, far = 1.0;  // of the edges that absorption alone leaves
};

// H Fig 4 and 5: absorption alone, scattering of the same strength, both with twice the blur. H Fig 1: over the right two thirds.
Result<Blurred> figures_4_and_5(Section& section, const Pictured& scene, const char* figure) {
  const auto made = [&](double kappa_a, double kappa_s, double lambda) {
    return under_haze(scene.light, scene.range, haze_optics(kappa_a, kappa_s, lambda), kAirlight,
                      DiffusionScheme::matched);
  };
  const auto absorbed = made(0.25, 0.0, 15.0), scattered = made(0.0, 0.25, 15.0), both = made(0.25, 0.25, 30.0);
  for (const auto* one : {&absorbed, &scattered, &both})
    if (!*one) return fail(one->error());
  auto two_thirds = both->light;
  for (int y = 0; y < two_thirds.height(); ++y)
    std::copy_n(scene.light.row(y), two_thirds.width() / 3, two_thirds.row(y));
  ContactSheet sheet;
  sheet.add(encoded(scene.light), "as taken");
  sheet.add(encoded(absorbed->light), "kappa_a .25");
  sheet.add(encoded(scattered->light), "kappa_s .25, lambda 15");
  sheet.add(encoded(both->light), "kappa_a .25, kappa_s .25, lambda 30");
  sheet.add(encoded(two_thirds), "H Fig 1: on the right two thirds");
  section.picture(sheet.drawn(2), fmt::format("{}: {}", figure, scene.name), 1000);
  const auto [near, far] = nearest_and_farthest(scene);
  return Blurred{edges(scene, scattered->light, 0.0, near) / edges(scene, absorbed->light, 0.0, near),
                 edges(scene, scattered->light, far, 9.0) / edges(scene, absorbed->light, far, 9.0)};
}

Image<Rgb8> range_picture(const Image<float>& range, float farthest) {
  Image<Rgb8> picture(range.width(), range.height());
  for (std::size_t i = 0; i < range.elements().size(); ++i) {
    const float value = range.elements()[i];
    const auto grey = static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value / farthest, 0.0F, 1.0F)));
    picture.elements()[i] = value > 0.0F ? Rgb8(grey, grey, grey) : Rgb8(200, 30, 30);
  }
  return picture;
}

// H Fig 3: holes filled, the sky behind everything, nothing that was measured altered.
void figure_3(Section& section, const Pictured& scene) {
  ContactSheet sheet;
  sheet.add(range_picture(scene.measured_m, static_cast<float>(scene.range.farthest_m)), "measured; missing is red");
  sheet.add(range_picture(scene.range.range, scene.range.sky_share > 0.0 ? 1.25F : 1.0F), "completed");
  section.picture(sheet.drawn(2), "H Fig 3: " + scene.name, 1000);
  double altered = 0.0;
  int left = 0, missing = 0;
  for (std::size_t i = 0; i < scene.measured_m.elements().size(); ++i) {
    const double was = static_cast<double>(scene.measured_m.elements()[i]) / scene.range.farthest_m;
    const auto is = static_cast<double>(scene.range.range.elements()[i]);
    left += !(is > 0.0);
    missing += !(was > 0.0);
    if (was > 0.0) altered = std::max(altered, std::abs(is - was));
  }
  section.figure("figure_3_altered." + scene.name, altered);
  section.finding(
      altered < 1e-5 && left == 0 ? Finding::reproduced : Finding::differs,
      fmt::format("H Fig 3 ({}): of {} undefined pixels {} are left, in {} holes and {:.0f} % of sky; what was "
                  "measured is altered by {:.0e} of the farthest at most.",
                  scene.name, missing, left, scene.range.holes, 100.0 * scene.range.sky_share, altered));
}

Result<Pictured> motorcycle(const ReportOptions& options) {
  const auto folder = options.shared_data / "rgbd" / "motorcycle";
  const auto photograph = read_photograph(folder / "left.png");
  if (!photograph) return fail(photograph.error());
  const auto depth =
      read_distances(folder / "depth_m.pfm", {}, photograph->encoded.width(), photograph->encoded.height());
  if (!depth) return fail(depth.error());
  const Camera camera;
  Image<glm::vec3> light(photograph->encoded.width(), photograph->encoded.height());
  for (std::size_t i = 0; i < light.elements().size(); ++i)
    light.elements()[i] = glm::vec3(camera.response.to_light(glm::dvec3(photograph->encoded.elements()[i])));
  auto range = prepare_range(depth->metres, {.smallest_sky_share = 1.0});
  if (!range) return fail(range.error());
  return Pictured{"Middlebury's Motorcycle (H: another of that set)", light, *range, depth->metres};
}

Result<Pictured> outdoors(const ReportOptions& options) {
  Place place;
  place.width = options.quick ? 120 : 640;
  place.height = options.quick ? 68 : 360;
  const auto scene = scene_at(land_at(place), 1.9, 51);
  auto range = prepare_range(scene.distance_m);
  if (!range) return fail(range.error());
  return Pictured{"a generated landscape (H: SYNS, which is not here)", scene.light, *range, scene.distance_m};
}

}  // namespace

Section haze_pictures_section(const ReportOptions& options) {
  Section section("haze-pictures", "Haze over pictures: H Fig 1, 3, 4 and 5");
  section.say(
      "H's coefficients, per farthest range: absorption alone; scattering that takes as much and blurs; both. By our "
      "scheme, on the CPU.");
  struct Shown {
    Result<Pictured> scene;
    const char* figure;
  };
  for (const auto& [scene, figure] : {Shown{motorcycle(options), "H Fig 4"}, Shown{outdoors(options), "H Fig 5"}}) {
    if (!scene) {
      section.finding(Finding::skipped, scene.error().message);
      continue;
    }
    figure_3(section, *scene);
    const auto blurred = figures_4_and_5(section, *scene, figure);
    if (!blurred) {
      section.finding(Finding::skipped, blurred.error().message);
      continue;
    }
    section.figure(fmt::format("{}.near", figure), blurred->near);
    section.figure(fmt::format("{}.far", figure), blurred->far);
    section.finding(
        blurred->near > 0.9 && blurred->far < 0.8 ? Finding::reproduced : Finding::differs,
        fmt::format(
            "{}: near things stay sharp, far ones blur. Of the edges that absorption of the same strength "
            "leaves, scattering leaves {:.0f} % in the nearest tenth, which here ends at {:.2f} of the farthest "
            "range, and {:.0f} % in the farthest three tenths.",
            figure, 100.0 * blurred->near, nearest_and_farthest(*scene).first, 100.0 * blurred->far));
  }
  return section;
}

}  // namespace kasumi::paper
