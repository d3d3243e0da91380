#include "pipeline/lab/haze/retarget_task.hpp"

#include <algorithm>
#include <cstdlib>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "base/finite_number.hpp"
#include "base/utc_text.hpp"
#include "calib/mask/scene_planes.hpp"
#include "estimator/photograph/haze_colour.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/lab/photographs/sky_model_choice.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"
#include "pipeline/site/config/descriptions.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

// "2.5", or "2:8:.25": from, to, step. Empty: neither.
std::vector<double> one_or_sweep(const std::string& text, double least, double most) {
  const auto parts = CLI::detail::split(text, ':');
  std::vector<double> values;
  for (const auto& part : parts)
    if (const auto value = finite_number(part)) values.push_back(*value);
  const auto good = [&](double value) { return value >= least && value <= most; };
  if (parts.size() == 1 && values.size() == 1 && good(values[0])) return values;
  const bool sweep = parts.size() == 3 && values.size() == 3 && good(values[0]) && good(values[1]) && values[2] > 0.0 &&
                     values[0] < values[1] && (values[1] - values[0]) / values[2] <= 10e3;
  std::vector<double> steps;
  for (int i = 0; sweep && values[0] + i * values[2] <= values[1] + 1e-9; ++i)
    steps.push_back(std::min(values[0] + i * values[2], values[1]));
  return steps;
}

// Whether source and targets are aerosols rather than the papers' T alone.
bool aerosol_known(const RetargetRequest& arguments) {
  return arguments.aerosol.any() || !arguments.aods.empty() || arguments.source_aod;
}
// An aerosol of their exponent and kind.
std::optional<Aerosol> like(const RetargetRequest& arguments) {
  return aerosol_known(arguments) ? std::optional(arguments.aerosol.given().with(0.0)) : std::nullopt;
}

// "clear", or a value or sweep of --turbidity or --aod.
template <class AirOf>
void read_targets(const std::vector<std::string>& texts, double least, double most, std::string_view expected,
                  AirOf air_of, std::vector<std::optional<AirState>>& targets, Problems& problems) {
  for (const auto& text : texts) {
    if (text == "clear") {
      targets.push_back(std::nullopt);
      continue;
    }
    const auto values = one_or_sweep(text, least, most);
    if (values.empty()) problems.add("{}", fmt::format(fmt::runtime(expected), text));
    for (const double value : values) targets.push_back(air_of(value));
  }
}

void read_targets(const RetargetRequest& a, std::vector<std::optional<AirState>>& targets, Problems& problems) {
  if (a.turbidities.empty() == a.aods.empty())
    problems.add("expected --turbidity or --aod: one of the two describes the target air");
  read_targets(
      a.turbidities, kLowestTurbidity.value, kHighestTurbidity.value,
      "--turbidity {}: expected a T of 1.7 to 20, FROM:TO:STEP, or clear",
      [&](double t) { return air_of(Turbidity{t}, like(a)); }, targets, problems);
  read_targets(
      a.aods, 0.0, kHighestGivenAod, "--aod {}: expected an optical depth of 0 to 1.8, FROM:TO:STEP, or clear",
      [&](double aod) { return AirState(a.aerosol.given().with(aod)); }, targets, problems);
}

// The pictures' own air: given, or estimated from a picture of the sky.
Result<AirState> source_air(const RetargetRequest& arguments, const CalibrationContents& camera,
                            const std::optional<Utc>& utc, const std::optional<SunDirection>& sun) {
  if (arguments.source_aod) return AirState(arguments.aerosol.given().with(*arguments.source_aod));
  if (arguments.source_turbidity) return air_of(Turbidity{*arguments.source_turbidity}, like(arguments));
  PhotographSetup setup;
  setup.calibrated = camera.sky;
  setup.site = camera.site;
  setup.utc = utc;
  setup.allow_damaged = arguments.allow_damaged;
  if (!utc) setup.sun = sun;
  setup.sun_from_image = !utc && !sun;
  Problems problems;
  setup.estimate.sky = model_to_fit(arguments.sky_model, camera.site ? camera.site->altitude_m : arguments.altitude_m,
                                    arguments.aerosol.given(), problems);
  if (!problems.empty()) return fail(problems.fault());
  const auto report = PhotographEstimator(std::move(setup)).estimate_from(arguments.sky, utc);
  if (!report) return fail(report.error());
  if (!report->damage.empty()) spdlog::warn("{}: {}; what is left of it is used", arguments.sky, report->damage);
  const auto& estimate = report->look.estimate;
  if (!estimate.usable)
    return fail(FaultKind::bad_input,
                "{}: no turbidity can be estimated from this sky ({}): expected another picture, --source-turbidity "
                "or --source-aod",
                arguments.sky, estimate.reason);
  fmt::print("source: T {:.2f} +- {:.2f} from {}\n", estimate.turbidity.value, estimate.sigma, arguments.sky);
  if (report->air->aerosol_known()) fmt::print("source: {}\n", text_of(report->air->aerosol()));
  // Where the targets are aerosols the source is one, too, if only one as usual with that T.
  return report->air->aerosol_known() ? *report->air : air_of(estimate.turbidity, like(arguments), estimate.sigma);
}

std::optional<glm::dvec3> light_of(const std::vector<double>& values) {
  if (values.size() != 3) return std::nullopt;
  return glm::dvec3(values[0], values[1], values[2]);
}

// Reads the distances; exactly one of the options for them must be given.
void read_depth(const RetargetRequest& a, SourceConditions& setup, Problems& problems) {
  const int ways = a.distances.ways() + (a.planes.empty() ? 0 : 1) + (a.distance_m ? 1 : 0) + (a.from_haze ? 1 : 0);
  if (ways != 1)
    return problems.add(
        "expected one of --depth FILE, --planes FILE, --disparity FILE, --inverse-depth FILE, --distance-m for one "
        "distance of everything but the sky, or --from-haze when nothing is known");
  setup.everything_at_m = a.distance_m;
  setup.from_haze = a.from_haze;
  const int width = setup.camera.width, height = setup.camera.height;
  if (a.distances.ways() == 1) {
    if (const auto distances = read_distances(a.distances, true, width, height, problems))
      setup.distance_m = sky_as_zero(*distances);
  } else if (!a.planes.empty()) {
    const auto planes = read_scene_planes(a.planes);
    if (!planes) return problems.add("{}", planes.error().message);
    setup.distance_m = distances_to(*planes, setup.camera);
    setup.find_sky = planes->sky_from_picture();
  }
}

// Whether the haze's exponent was not given. A T with a sun asks for the papers' sky, to which their haze belongs.
bool may_ask_the_picture(const RetargetRequest& a, const SourceConditions& setup) {
  if (a.scattering != "auto" || a.aerosol.describes_kind()) return false;
  return a.source_aod || (a.source_turbidity && !(setup.sun && a.aods.empty()));
}

// The exponent of the aerosol in air like `air`, by the first picture; empty: undetermined. Prints the result.
std::optional<double> exponent_of(const Photograph& first, const SourceConditions& setup, const AirState& air) {
  const auto colour = haze_colour_of(setup.camera, hazy_picture(setup.camera, first));
  if (!colour.told) {
    const auto supposed = setup.from_haze       ? std::string("grey haze")
                          : air.aerosol_known() ? fmt::format("an exponent of {:.1f}", air.aerosol().angstrom_exponent)
                                                : std::string("the papers' haze");
    fmt::print("haze: {} is supposed, the picture does not determine its exponent ({})\n", supposed, colour.reason);
    return std::nullopt;
  }
  const double exponent = aerosol_exponent(colour, air);
  fmt::print("haze: exponent {:.2f} +- {:.2f} of its aerosol, by the picture\n", exponent, colour.sigma);
  return exponent;
}

// Of the same amount but of that exponent: the papers' haze stays as thick as it is at 550 nm.
AirState with_exponent(const AirState& air, double exponent) {
  auto aerosol = air.aerosol();
  if (!air.aerosol_known()) aerosol.aod_550 = mie_per_m(ScatteringModel::morales2017, 550.0, air) * kAerosolHeight_m;
  aerosol.angstrom_exponent = exponent;
  return {aerosol, air.covariance()};
}

}  // namespace

Result<RetargetTask> retarget_task(const RetargetRequest& a, const Photograph& first) {
  RetargetTask task;
  auto& setup = task.setup;
  Problems problems;
  read_targets(a, task.targets, problems);
  CalibrationContents file;
  if (!a.camera.empty()) {
    auto read = read_camera_file(a.camera);
    if (!read)
      problems.add("{}", read.error().message);
    else
      file = std::move(*read);
  }
  const int width = first.encoded.width(), height = first.encoded.height();
  setup.camera =
      file.scene.value_or(plain_camera(width, height, from_degrees(a.field_of_view_deg), from_degrees(a.pitch_deg)));
  setup.altitude_m = file.site ? file.site->altitude_m : a.altitude_m;

  std::optional<Utc> utc;
  if (!a.utc.empty()) {
    utc = parse_utc(a.utc);
    if (!utc) problems.add("--utc {}: expected a time like 2018-01-29T11:09:20Z", a.utc);
    if (!file.site) problems.add("--utc: expected a --camera file with [site], which places the sun");
  }
  if (a.sun_zenith_deg.has_value() != a.sun_azimuth_deg.has_value())
    problems.add("--sun-zenith-deg and --sun-azimuth-deg: expected both or neither");
  else if (a.sun_zenith_deg)
    setup.sun = direction_from(from_degrees(*a.sun_zenith_deg), from_degrees(*a.sun_azimuth_deg));
  else if (utc && file.site)
    setup.sun = sun_position(*utc, *file.site).direction;

  if (setup.camera.width != width || setup.camera.height != height)
    problems.add("{}: [scene] is {} x {}: expected {} x {}, as the picture is", a.camera, setup.camera.width,
                 setup.camera.height, width, height);
  else
    read_depth(a, setup, problems);
  if ((a.source_turbidity ? 1 : 0) + (a.source_aod ? 1 : 0) + (a.sky.empty() ? 0 : 1) != 1)
    problems.add("expected one of --source-turbidity T, --source-aod, or --sky PICTURE to find it in");
  if (!a.target_airlight.empty() && !a.target_picture.empty())
    problems.add("--target-airlight and --target-picture: expected only one of them");
  if (a.terms && a.out.empty()) problems.add("--terms: expected --out, which names where its pictures go");
  if (!problems.empty()) return fail(problems.fault());

  const auto source = source_air(a, file, utc, setup.sun);
  if (!source) return fail(source.error());
  setup.source = *source;
  // Other amounts of what is in the air.
  for (auto& target : task.targets)
    if (target && source->aerosol_known() && !target->aerosol_known())
      target = air_of(target->turbidity(), source->aerosol());
  for (const auto& target : task.targets) task.target_names.push_back(target ? name_of(*target) : "clear");
  setup.grey_from_haze = !a.aerosol.describes_kind();
  if (may_ask_the_picture(a, setup))
    if (const auto exponent = exponent_of(first, setup, setup.source)) {
      setup.grey_from_haze = false;
      setup.source = with_exponent(setup.source, *exponent);
      for (auto& target : task.targets)
        if (target) target = with_exponent(*target, *exponent);
    }
  setup.airlight = light_of(a.airlight);
  setup.target_airlight = light_of(a.target_airlight);
  setup.scattering = scattering_model_named(a.scattering);
  setup.relight = !a.keep_reflectance;
  setup.amplify_noise = a.amplify_noise;
  setup.same_exposure = a.same_exposure;
  setup.largest_gain = a.largest_gain;
  setup.terms = a.terms;
  if (!a.target_picture.empty()) {
    const auto picture = read_photograph(a.target_picture);
    if (!picture) return fail(picture.error());
    if (picture->encoded.width() != width || picture->encoded.height() != height)
      return fail(FaultKind::bad_input, "{}: is {} x {}: expected {} x {}, taken by the same camera", a.target_picture,
                  picture->encoded.width(), picture->encoded.height(), width, height);
    auto horizon = horizon_of(setup.camera, *picture, a.target_picture);
    if (!horizon) return fail(horizon.error());
    setup.target_horizon = std::move(*horizon);
  }
  return task;
}

}  // namespace kasumi
