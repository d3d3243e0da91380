#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/adopt_calibration.hpp"
#include "calib/calibration_file.hpp"
#include "calib/mask/image_circle.hpp"
#include "calib/pose/orientation_fit.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/orientation_series.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibrate/series_pictures.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/site/config/fixture_file.hpp"

namespace kasumi {

namespace {

constexpr Radians kLowestSunForOrientation = from_degrees(5.0);  // lower, refraction is uncertain and the sun no disc
constexpr double kCircleSigma_px = 0.5;

struct FisheyeArguments {
  std::vector<std::string> pictures;
  std::string fixture;  // of a recording: the only one of `pictures`
  std::optional<double> lat, lon;
  double altitude_m = 0.0;
  PictureTimes times;
  std::vector<double> circle;
  std::string serial;
  std::optional<double> level_sigma_deg;
  double focal_sigma_percent = 3.0;
  std::string out;
};

// The initial lens: calibrated, or as the recording describes it.
struct KnownLens {
  LensDescription lens;
  bool calibrated = false;
  std::optional<std::string> response;  // the recording's, unless it is a table
};

Result<KnownLens> known_lens(const FisheyeArguments& arguments, const Fixture& fixture) {
  const auto root = ConfigTable::read_file(fixture.folder / "fixture.toml");
  if (!root) return fail(root.error());
  adopt_calibration(*root);
  KnownLens known{read_lens_description(root->table("sky").table("lens")), false, std::nullopt};
  if (const auto word = root->table("sky").text("response"); word != "table") known.response = word;
  std::error_code error;
  if (!std::filesystem::exists(arguments.out, error)) return known;
  const auto before = ConfigTable::read_file(arguments.out);
  if (!before) return fail(before.error());
  const auto sky = before->optional_table("sky");
  const auto measured = sky ? sky->optional_table("measured") : std::nullopt;
  if (!measured || !measured->has("lens") || !sky->has("lens")) return known;
  const auto& camera = fixture.installation.sky;
  if (sky->integer("width") != camera.width || sky->integer("height") != camera.height)
    return fail(FaultKind::bad_input, "{}: sky: its lens is for {} x {} pictures, the recording has {} x {}",
                arguments.out, sky->integer("width"), sky->integer("height"), camera.width, camera.height);
  known.lens = read_lens_description(sky->table("lens"));
  known.calibrated = true;
  for (const char* key : {"calibration", "site", "sky", "scene"}) before->ignore(key);
  if (auto whole = before->finish(); !whole) return fail(whole.error());
  return known;
}

struct SunSights {
  std::vector<SunSight> sights;
  Image<Rgb8> brightest;  // over all pictures: shows the rim wherever it was lit at least once
  PicturesRead read;
  int without_sun = 0, too_low = 0;
};

Result<SunSights> find_suns(const Fixture& fixture, const Camera& camera) {
  SunSights suns;
  const auto take_picture = [&](const PictureView& view, const FrameMetadata& metadata) {
    keep_brightest(suns.brightest, to_rgb(view));
    const auto sun = sun_position(metadata.utc, fixture.installation.site);
    if (sun.zenith > from_degrees(90.0) - kLowestSunForOrientation) {
      ++suns.too_low;
      return;
    }
    const auto picture = sky_picture(view, camera, kLargestSide);
    const auto blob = picture ? find_sun(*picture, camera) : std::nullopt;
    if (blob)
      suns.sights.push_back({sun.direction, blob->pixel});
    else
      ++suns.without_sun;
  };
  const auto read = for_each_picture(fixture, camera, {}, take_picture);
  if (!read) return fail(read.error());
  suns.read = *read;
  return suns;
}

OrientationPrior prior_of(const FisheyeArguments& arguments, const Camera& camera, const KnownLens& known,
                          const std::optional<ImageCircle>& circle) {
  OrientationPrior prior;
  prior.lens = known.lens;
  prior.to_world = camera.to_world;
  prior.level_sigma = from_degrees(arguments.level_sigma_deg.value_or(3.0));
  if (known.calibrated) {
    prior.centre_sigma_px = glm::dvec2(0.2);
    prior.scale_sigma = 0.002;
    return prior;
  }
  prior.scale_sigma = 0.01 * arguments.focal_sigma_percent;
  if (circle) {
    prior.lens = moved(known.lens, circle->centre, 1.0);
    prior.centre_sigma_px = glm::dvec2(kCircleSigma_px);
  } else {
    prior.centre_sigma_px = glm::dvec2(0.01 * std::max(camera.width, camera.height));
  }
  return prior;
}

// The angle off the axis at the circle's edge, by the lens as it was fitted.
std::optional<Radians> edge_of(const LensDescription& lens, const ImageCircle& circle) {
  auto wide = lens;
  wide.largest_angle = from_degrees(150.0);
  const auto ray = make_lens(wide)->unproject(centre_of(lens) + glm::dvec2{circle.radius_px, 0.0});
  if (!ray) return std::nullopt;
  return angle_between(*ray, {0.0, 0.0, 1.0});
}

std::vector<Measured> measured_of(const Fixture& fixture, const SunSights& suns, const KnownLens& known,
                                  const OrientationFit& found, const std::optional<ImageCircle>& circle,
                                  const std::string& now) {
  const auto used = std::count(found.used.begin(), found.used.end(), true);
  const auto from = fmt::format("the sun in {} of {} pictures of the recording {}, {} to {}", used, suns.read.good,
                                fixture.info.name, utc_text(suns.read.first), utc_text(suns.read.last));
  const auto& sigma = found.sigma;
  Measured orientation{"orientation",
                       now,
                       from,
                       {{"rms_px", found.rms_px},
                        {"azimuth_sigma_deg", to_degrees(sigma.azimuth)},
                        {"tilt_east_sigma_deg", to_degrees(sigma.tilt_east)},
                        {"tilt_north_sigma_deg", to_degrees(sigma.tilt_north)},
                        {"centre_x_sigma_px", sigma.centre_px.x},
                        {"centre_y_sigma_px", sigma.centre_px.y},
                        {"focal_sigma_percent", 100.0 * sigma.scale},
                        {"focal_scale", found.scale}},
                       found.undetermined};
  orientation.remarks.push_back(known.calibrated ? "the lens was calibrated before"
                                                 : "the lens was as the recording describes it");
  std::vector<Measured> all{orientation};
  if (circle) {
    Measured rim{"image_circle", now, from, {}, {}};
    rim.numbers = {
        {"centre_x_px", circle->centre.x}, {"centre_y_px", circle->centre.y}, {"radius_px", circle->radius_px}};
    if (const auto edge = edge_of(found.lens, *circle))
      rim.numbers.emplace_back("field_of_view_deg", 2.0 * to_degrees(*edge));
    all.push_back(rim);
  }
  return all;
}

void report(const SunSights& suns, const OrientationFit& found, const std::optional<ImageCircle>& circle) {
  const auto used = std::count(found.used.begin(), found.used.end(), true);
  fmt::print("{} pictures: the sun in {}, not seen in {}, too low in {}; {} damaged\n", suns.read.good,
             suns.sights.size(), suns.without_sun, suns.too_low, suns.read.damaged);
  fmt::print("{} used, rms {:.2f} px; {} rejected\n", used, found.rms_px,
             static_cast<std::ptrdiff_t>(suns.sights.size()) - used);
  const auto angles = heading_pitch_roll(found.to_world);
  fmt::print("heading {:.3f}, pitch {:.3f}, roll {:.3f} deg\n", to_degrees(angles.heading), to_degrees(angles.pitch),
             to_degrees(angles.roll));
  fmt::print("uncertainty: azimuth {:.3f} deg, tilt {:.3f} deg (east) and {:.3f} deg (north)\n",
             to_degrees(found.sigma.azimuth), to_degrees(found.sigma.tilt_east), to_degrees(found.sigma.tilt_north));
  const auto centre = centre_of(found.lens);
  fmt::print("centre ({:.2f} +- {:.2f}, {:.2f} +- {:.2f}) px, focal length {:.2f} px +- {:.2f} %\n", centre.x,
             found.sigma.centre_px.x, centre.y, found.sigma.centre_px.y, focal_px_of(found.lens),
             100.0 * found.sigma.scale);
  if (circle)
    fmt::print("image circle: centre ({:.1f}, {:.1f}), radius {:.1f} px\n", circle->centre.x, circle->centre.y,
               circle->radius_px);
  else
    fmt::print("image circle: its rim is not visible\n");
  for (const auto& remark : found.undetermined) fmt::print("undetermined: {}\n", remark);
  fmt::print("a clock 4 s off turns the sky by up to 1/60 deg, which looks like an azimuth error\n");
}

Result<int> calibrate_strange(const FisheyeArguments& arguments) {
  Problems problems;
  if (!arguments.lat || !arguments.lon)
    problems.add("{}: is no recording with a site of its own: expected --lat and --lon", arguments.pictures.front());
  OrientationSeries series{arguments.pictures, arguments.times, {}, {}, arguments.level_sigma_deg.value_or(5.0),
                           arguments.serial,   arguments.out};
  series.site = {"", arguments.lat.value_or(0.0), arguments.lon.value_or(0.0), arguments.altitude_m};
  if (!arguments.circle.empty()) {
    series.circle = ImageCircle{{arguments.circle[0], arguments.circle[1]}, arguments.circle[2]};
    if (!(arguments.circle[2] > 0.0)) problems.add("--circle: radius {} px, expected more than 0", arguments.circle[2]);
  }
  if (!problems.empty()) return fail(problems.fault());
  return calibrate_sky_series(series);
}

Result<int> calibrate_recording(const FisheyeArguments& arguments) {
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) return fail(fixture.error());
  const auto known = known_lens(arguments, *fixture);
  if (!known) return fail(known.error());
  Camera camera = fixture->installation.sky;
  camera.lens = make_lens(known->lens);
  const auto suns = find_suns(*fixture, camera);
  if (!suns) return fail(suns.error());
  const auto seen = find_image_circle(suns->brightest);
  constexpr double kSure = 0.5;
  const auto circle = seen && seen->confidence > kSure ? std::optional(seen->circle) : std::nullopt;
  const auto found = fit_orientation(suns->sights, prior_of(arguments, camera, *known, circle));
  if (!found) return fail(found.error().kind, "{}: {}", arguments.fixture, found.error().message);
  report(*suns, *found, circle);

  CalibrationStep step;
  step.camera = "sky";
  step.width = camera.width;
  step.height = camera.height;
  step.serial = arguments.serial;
  step.lens = found->lens;
  step.to_world = found->to_world;
  step.response = known->response;
  step.site = fixture->installation.site;
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  step.calibrated_utc = now;
  step.measured = measured_of(*fixture, *suns, *known, *found, circle, now);

  const auto title = fmt::format("{}: rms {:.2f} px, azimuth +- {:.3f} deg", fixture->info.name, found->rms_px,
                                 to_degrees(found->sigma.azimuth));
  return save_calibration(arguments.out, std::move(step), plot_sun_track(suns->brightest, suns->sights, *found, title));
}

Result<int> calibrate(FisheyeArguments arguments) {
  std::error_code error;
  const std::filesystem::path first = arguments.pictures.front();
  if (arguments.pictures.size() > 1 || !std::filesystem::exists(first / "fixture.toml", error))
    return calibrate_strange(arguments);
  arguments.fixture = first.string();
  return calibrate_recording(arguments);
}

}  // namespace

void add_calibrate_sky(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "sky",
      "The sky camera's orientation and lens from the sun's path in a recording, or all of an unknown camera from "
      "pictures with times");
  auto arguments = std::make_shared<FisheyeArguments>();
  auto& a = *arguments;
  command
      ->add_option(
          "pictures", a.pictures,
          "A recording with hours of sun; or pictures of an unknown camera over a day: a folder, @LIST, a pattern "
          "in quotes, as `kasumi estimate` takes them")
      ->required();
  command->add_option("--lat", a.lat, "Where an unknown camera stands, degrees north")->check(CLI::Range(-90.0, 90.0));
  command->add_option("--lon", a.lon, "Degrees east")->check(CLI::Range(-180.0, 180.0));
  command->add_option("--altitude-m", a.altitude_m, "Height above the sea")
      ->check(CLI::Range(-500.0, 9000.0))
      ->capture_default_str();
  command->add_option("--time-format", a.times.format,
                      "Of the times in the pictures' names, as strptime has it: %Y%m%d_%H%M%S. Default: what is usual, "
                      "else EXIF");
  command->add_option("--utc-offset-h", a.times.utc_offset_h, "Of those times from UTC: 9 in Japan")
      ->check(CLI::Range(-14.0, 14.0))
      ->capture_default_str();
  command
      ->add_option("--circle", a.circle, "Image circle of an unknown camera in pixels; default: found in its pictures")
      ->type_name("CX,CY,R")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command
      ->add_option("--level-deg", a.level_sigma_deg,
                   "Uncertainty of the camera's levelling, one standard deviation. Default: 3; of an unknown camera 5")
      ->check(CLI::Range(0.05, 30.0));
  command
      ->add_option("--focal-percent", a.focal_sigma_percent,
                   "Uncertainty of the focal length, unless calibrate lens has measured it")
      ->check(CLI::Range(0.05, 30.0))
      ->capture_default_str();
  command
      ->add_option("--out", a.out,
                   "The calibration file; its lens, if any, is the initial one, and an older file is kept as a backup")
      ->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi
