#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/alpnach.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {
namespace {

void figure_7(Section& section, const ReportOptions& options) {
  const int side = options.quick ? 120 : 500;
  const Camera camera = test::upward_camera(side);
  ContactSheet sheet;
  double worst = 0.0;
  for (int t = 2; t <= 9; ++t) {
    const auto sky = test::render({.turbidity = static_cast<double>(t)}, camera);
    const auto pixels = sky.to_8_bit();
    const auto picture = sky_picture(view_of(pixels), camera);
    const auto found = estimate_turbidity(*picture, camera, sky.sun);
    worst = std::max(worst, std::abs(found.turbidity.value - t));
    sheet.add(pixels, fmt::format("T {}, found {:.2f} +- {:.2f}", t, found.turbidity.value, found.sigma));
  }
  section.picture(sheet.drawn(4), "M Fig 7: Preetham's skies, sun 58.4 deg from the zenith, and T found in each", 1000);
  section.figure("figure_7_worst", worst);
  section.finding(worst < 0.1 ? Finding::reproduced : Finding::differs,
                  fmt::format("M Fig 7: each of the eight skies gives back its T within {:.3f}.", worst));
}

// M Fig 8, M14 Fig 6: photographs of skies, the T found in them, and Preetham's sky of that T. The papers' are not
// public; there is one sky here in several exposures.
void figure_8(Section& section, const ReportOptions& options) {
  const auto folder = options.shared_data / "sky" / "skycam-alpnach";
  if (!std::filesystem::exists(folder)) {
    section.finding(Finding::skipped, fmt::format("{}: not there.", folder.string()));
    return;
  }
  const Camera camera = alpnach::camera();
  const SunDirection sun = *camera.direction_at(alpnach::kSun);
  ContactSheet sheet;
  double least = 1e9, most = 0.0, sigma = 0.0;
  int usable = 0;
  std::string shown;
  for (int exposure = 0; exposure < alpnach::kExposures; ++exposure) {
    const auto photograph = read_photograph(folder / alpnach::file(exposure).filename());
    if (!photograph) {
      section.finding(Finding::skipped, photograph.error().message);
      return;
    }
    const auto pixels = to_rgb8(*photograph);
    const auto picture = sky_picture(view_of(pixels), camera);
    const auto found = estimate_turbidity(*picture, camera, sun);
    if (!found.usable) continue;
    ++usable;
    least = std::min(least, found.turbidity.value);
    most = std::max(most, found.turbidity.value);
    sigma = std::max(sigma, found.sigma);
    shown += fmt::format("{}{:.2f} +- {:.2f}", shown.empty() ? "" : ", ", found.turbidity.value, found.sigma);
    sheet.add(pixels, fmt::format("exposure {}: T {:.2f}", exposure, found.turbidity.value));
    const auto drawn = test::render({.turbidity = std::max(1.7, found.turbidity.value),
                                     .sun_zenith_deg = to_degrees(zenith_angle(sun)),
                                     .sun_azimuth_deg = to_degrees(azimuth_angle(sun))},
                                    test::upward_camera(300));
    sheet.add(drawn.to_8_bit(), fmt::format("Preetham's sky of T {:.2f}", found.turbidity.value));
  }
  section.figure("figure_8_usable", usable);
  if (usable == 0) {
    section.finding(Finding::skipped, "no exposure of Alpnach's sky is usable.");
    return;
  }
  section.picture(sheet.drawn(2), "M Fig 8, M14 Fig 6: Alpnach's winter sky, and the Preetham sky of the T found", 640);
  section.figure("figure_8_spread", most - least);
  section.finding(
      most - least < 2.0 * sigma ? Finding::reproduced : Finding::differs,
      fmt::format("M Fig 8 on another sky (the papers' photographs are not public): {} of 13 exposures of one sky "
                  "are usable and give T {}. Nobody measured the air, so agreement between exposures is all that "
                  "can be seen.",
                  usable, shown));
}

}  // namespace

Section sky_pictures_section(const ReportOptions& options) {
  Section section("sky-pictures", "Skies and their T: M Fig 7 and 8, M14 Fig 6");
  figure_7(section, options);
  figure_8(section, options);
  return section;
}

}  // namespace kasumi::paper
