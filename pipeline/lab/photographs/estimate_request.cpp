#include "pipeline/lab/photographs/estimate_request.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <CLI/CLI.hpp>

#include "base/finite_number.hpp"
#include "base/utc_text.hpp"
#include "calib/adopt_calibration.hpp"
#include "calib/foreign_keys.hpp"
#include "estimator/papers/reference_pixel.hpp"
#include "pipeline/lab/photographs/sky_model_choice.hpp"

namespace kasumi {

namespace {

Result<> read_calibration(const std::string& file, PhotographSetup& options) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  if (root->has("format")) adopt_calibration(*root);  // a fixture's description, which may name one
  if (auto site = root->optional_table("site")) options.site = read_site(*site);
  options.calibrated = read_camera(root->table("sky"), "sky");
  ignore_what_others_read(*root, {"site", "sky"});
  return root->finish();
}

// The sun's position must be given in exactly one way.
void read_sun(const EstimateRequest& arguments, PhotographSetup& options, Problems& problems) {
  if (arguments.sun_zenith_deg.has_value() != arguments.sun_azimuth_deg.has_value())
    problems.add("--sun-zenith-deg and --sun-azimuth-deg: expected both or neither");
  if (arguments.lat.has_value() != arguments.lon.has_value()) problems.add("--lat and --lon: expected both or neither");
  if (arguments.sun_zenith_deg && arguments.sun_azimuth_deg)
    options.sun = direction_from(from_degrees(*arguments.sun_zenith_deg), from_degrees(*arguments.sun_azimuth_deg));
  if (arguments.lat && arguments.lon)
    options.site = Site{"", *arguments.lat, *arguments.lon, arguments.altitude_m.value_or(0.0)};
  if (!arguments.utc.empty()) {
    options.utc = parse_utc(arguments.utc);
    if (!options.utc) problems.add("--utc {}: expected a time like 2018-01-29T11:09:20Z", arguments.utc);
  }
  options.sun_from_image = arguments.sun_from_image;
  options.altitude_given = arguments.altitude_m.has_value();
  if (options.sun && options.utc)
    problems.add("--utc and --sun-zenith-deg: expected only one, both give the sun's position");
  if (!arguments.scans.empty() && !options.sun && !(options.site && options.utc))
    problems.add(
        "--scan: the sun's position is unknown: expected --sun-zenith-deg and --sun-azimuth-deg, or --utc with --lat "
        "and --lon (or a --calibration with [site])");
}

// What is given of an unmeasured camera.
void read_unknowns(const EstimateRequest& arguments, PhotographSetup& options, Problems& problems) {
  constexpr double kMostLost = 0.95;
  constexpr double kSigmaOfAltitude_m = 500.0;
  if (!arguments.altitude_m && arguments.calibration.empty()) options.sigma_altitude_m = kSigmaOfAltitude_m;
  options.tone_exponent = arguments.tone_exponent;
  if (arguments.tone_exponent && !options.unknown_camera)
    problems.add("--tone-exponent: is for cameras of unknown response, expected --response auto");
  if (!arguments.calibration.empty() && (arguments.tone_exponent || arguments.vignetting != "fit"))
    problems.add("--tone-exponent, --vignetting: a --calibration has a response and a vignetting of its own");
  if (arguments.vignetting == "fit") return;
  const auto lost = finite_number(arguments.vignetting);
  if (lost && *lost >= 0.0 && *lost <= kMostLost)
    options.rim_loss = *lost;
  else
    problems.add("--vignetting {}: expected fit, or the share of light lost at the rim, 0 to {}", arguments.vignetting,
                 kMostLost);
}

// The papers' method knows the papers' sky alone.
ModelToFit chosen_sky(const EstimateRequest& arguments, double altitude_m, Problems& problems) {
  const bool papers = arguments.method == "reference-pixel";
  const bool any = arguments.sky_model.empty() || arguments.sky_model == "auto" || arguments.sky_model == "automatic";
  const auto sky =
      model_to_fit(papers && any ? "preetham" : arguments.sky_model, altitude_m, arguments.aerosol.given(), problems);
  if (papers && (sky.model != DaylightModel::preetham || sky.every_model || sky.hosek))
    problems.add("--method reference-pixel: the papers' method needs the papers' sky, expected --sky-model preetham");
  return sky;
}

// What only a picture has.
void refuse_for_scans(const EstimateRequest& arguments, Problems& problems) {
  if (!arguments.images.empty() || !arguments.scenes.empty())
    problems.add("--scan: stands instead of pictures, expected none beside it");
  if (!arguments.cameras.empty()) problems.add("--camera: is for pictures, not for --scan");
  if (arguments.sun_from_image)
    problems.add("--sun-from-image: a scan is no picture, expected the sun's angles or a time");
  if (arguments.method == "reference-pixel") problems.add("--method reference-pixel: is for pictures, not for --scan");
  if (arguments.plot || !arguments.plot_dir.empty()) problems.add("--plot: is for pictures, not for --scan");
}

void add_archive_options(CLI::App& command, EstimateRequest& a) {
  command.add_option(
      "--time-format", a.time_format,
      "When pictures were taken, as strptime reads it somewhere in their names, with folders where it has "
      "a /, like %Y/%m/%d/%H%M; auto: as names usually say it, else EXIF. A picture without one is refused");
  command
      .add_option("--utc-offset-h", a.utc_offset_h, "Of those times from UTC: 9 in Japan; with --merge of the page's")
      ->check(CLI::Range(-14.0, 14.0));
  auto* out = command.add_option("--out", a.out,
                                 "Write records (JSON lines) into this new file instead, also of pictures that cannot "
                                 "be read; with --merge the table: .jsonl, .csv or .sqlite");
  command
      .add_option("--shard", a.shard,
                  "With --out: part I of N of the list. Default: the task of the job array (Slurm, Grid Engine, "
                  "Kubernetes with JOB_COMPLETIONS), else all")
      ->type_name("I/N")
      ->needs(out);
  command.add_flag("--resume", a.resume, "With --out: go on behind the records that are there")->needs(out);
  command.add_option("--learn-camera", a.learn_camera,
                     "Instead of answers: what a sample of the pictures tells of their camera, as --camera-memory FILE "
                     "for all shards");
  auto* merge =
      command
          .add_option("--merge", a.merge,
                      "Instead of pictures: all parts of an archive, files of --out, into one table and summary.html")
          ->type_name("PART");
  command
      .add_option("--photometer", a.photometers,
                  "With --merge: AERONET's tables of aerosol optical depth (version 3, .lev15 or .lev20), to compare")
      ->type_name("FILE")
      ->needs(merge);
  command
      .add_option("--summary", a.summary,
                  "With --merge: the page, and its figures as .json beside it. Default: summary.html beside --out")
      ->needs(merge);
}

}  // namespace

std::string words_of_answers(const CLI::App& command) {
  constexpr std::array<std::string_view, 14> kOthers{
      "image", "--list", "--jobs",     "--out",   "--shard",   "--resume",       "--json",
      "--csv", "--plot", "--plot-dir", "--merge", "--summary", "--learn-camera", "--photometer"};
  std::string words;
  for (const auto* option : command.get_options()) {
    const auto name = option->get_name();
    if (option->count() == 0 || std::ranges::find(kOthers, name) != kOthers.end()) continue;
    words += name;
    for (const auto& value : option->results()) words += " " + value;
    words += "\n";
  }
  return words;
}

Result<PhotographSetup> photograph_setup(const EstimateRequest& arguments) {
  PhotographSetup options;
  options.first_look = !arguments.plot && arguments.plot_dir.empty();  // of the whole picture
  Problems problems;
  if (!arguments.calibration.empty())
    if (auto read = read_calibration(arguments.calibration, options); !read) problems.add("{}", read.error().message);
  options.equisolid = arguments.lens == "equisolid";
  if (arguments.fov_deg) options.field_of_view = from_degrees(*arguments.fov_deg);
  if (!arguments.circle.empty()) {
    if (arguments.circle[2] > 0.0)
      options.circle = ImageCircle{{arguments.circle[0], arguments.circle[1]}, arguments.circle[2]};
    else
      problems.add("--circle: radius {} px, expected more than 0", arguments.circle[2]);
  }
  if (!arguments.scans.empty()) refuse_for_scans(arguments, problems);
  if (arguments.response_from_pictures() && !arguments.calibration.empty())
    problems.add("--response estimate: a --calibration has a response of its own");
  if (arguments.azimuth_up_deg) options.azimuth_up = from_degrees(*arguments.azimuth_up_deg);
  options.allow_damaged = arguments.allow_damaged;
  options.linear_response = arguments.response == "linear";
  read_sun(arguments, options, problems);
  if (arguments.method == "reference-pixel") options.estimate.solve = by_reference_pixel();
  const double altitude_m = options.site ? options.site->altitude_m : arguments.altitude_m.value_or(0.0);
  options.estimate.sky = chosen_sky(arguments, altitude_m, problems);
  const bool any_model = !options.estimate.solve && options.estimate.sky.every_model;
  options.unknown_camera = arguments.response == "auto" || (arguments.response.empty() && any_model);
  if (arguments.response == "auto" && !any_model)
    problems.add("--response auto: needs every model of the sky, expected --sky-model auto and --method free-gain");
  read_unknowns(arguments, options, problems);
  options.estimate.samples = arguments.samples;
  options.estimate.seed = arguments.seed;
  if (!problems.empty()) return fail(problems.fault());
  return options;
}

void add_estimate_options(CLI::App& command, EstimateRequest& arguments) {
  auto& a = arguments;
  command.add_option(
      "image", a.images,
      "Pictures of the sky; folders (their pictures by name); tar and zip files (theirs, in order; one alone as "
      "FILE.tar:NAME); recordings (folders with fixture.toml: "
      "their times, camera "
      "and site); @FILE or -: a list in a file or on standard input, one path a line, with a tab and "
      "its UTC where known; "
      "patterns in quotes, like 'DIR/*.jpg'. Default: -");
  command.add_option("--list", a.lists, "A list of pictures, as @FILE; - is standard input")
      ->type_name("FILE")
      ->allow_extra_args(false);
  auto* scene = command.add_option(
      "--scene", a.scenes,
      "Pictures of the scene camera, or a folder: visibility from --landmarks; alone or one for each of the sky");
  command
      .add_option("--scan", a.scans,
                  "Instead of pictures: tables of a sky scanner, CSV of azimuth_deg, elevation_deg and L380 ... L780, "
                  "or X, Y, Z, or luminance (docs/photographs.md)")
      ->type_name("FILE.csv");
  command.add_option("--landmarks", a.landmarks, "TOML of [[landmarks]] at known distance (docs/operating.md)")
      ->check(CLI::ExistingFile)
      ->needs(scene);
  command
      .add_option("--measured", a.measured,
                  "With --scene: CSV of name,visibility_m that an instrument measured (optical range, 5 %), to compare")
      ->check(CLI::ExistingFile)
      ->needs(scene);
  auto* haze = command.add_option("--haze", a.hazes,
                                  "Instead of pictures of the sky: photographs of land in haze, sRGB; the exponent of "
                                  "their haze, where they determine it");
  auto* part = command.add_option("--part", a.part, "With --haze: where in the picture its optical depth is read")
                   ->type_name("X,Y,WIDTH,HEIGHT")
                   ->delimiter(',')
                   ->expected(4)
                   ->needs(haze);
  command.add_option("--distance-m", a.distance_m, "With --part: how far what it shows is, for its extinction")
      ->check(CLI::Range(1.0, 200e3))
      ->needs(part);
  command.add_option("--calibration", a.calibration,
                     "TOML with [sky] (docs/cameras.md) and, if wanted, [site]; instead of the lens options");
  command
      .add_option("--camera", a.cameras,
                  "Such a file of each time that a camera stood as it did, given again for each, like "
                  "..2019-05-01=old.toml and 2019-05-01..=new.toml: UTC, the second day no part of it")
      ->type_name("FROM..TO=FILE")
      ->allow_extra_args(false);
  command.add_option("--lens", a.lens, "Fisheye model")
      ->check(CLI::IsMember({"equidistant", "equisolid"}))
      ->capture_default_str();
  command
      .add_option(
          "--fov-deg", a.fov_deg,
          "Field of view across the image circle. Default: 180, or the horizon's circle at 90 degrees where land "
          "is seen inside the image circle")
      ->check(CLI::Range(60.0, 250.0));
  command
      .add_option("--circle", a.circle, "Image circle in pixels: centre and radius; default: detected in the picture")
      ->type_name("CX,CY,R")
      ->delimiter(',')
      ->expected(3);
  command
      .add_option("--azimuth-up-deg", a.azimuth_up_deg,
                  "Azimuth of the image's top; azimuth increases counter-clockwise. Default: where the sun in the "
                  "picture puts it, else 0")
      ->check(CLI::Range(-360.0, 360.0));
  command
      .add_option(
          "--response", a.response,
          "Response curve of the pictures; estimate: a power over sRGB from all of them together, of one camera; auto: "
          "an unknown of each camera, as rim loss then is, and a part of what sigma holds. Default: auto; srgb with "
          "--method reference-pixel or one --sky-model")
      ->check(CLI::IsMember({"auto", "srgb", "linear", "estimate"}));
  command
      .add_option("--tone-exponent", a.tone_exponent,
                  "With --response auto: the power over sRGB, where it is known; default: found")
      ->check(CLI::Range(0.2, 5.0));
  command
      .add_option("--vignetting", a.vignetting,
                  "Light lost at the edge of the image circle, 0 to 0.95, or fit: an unknown with --response auto")
      ->capture_default_str();
  command.add_option("--camera-memory", a.camera_memory,
                     "File that keeps what pictures show of their cameras (circle, tone curve, orientation) for the "
                     "next call");
  command.add_option("--sun-zenith-deg", a.sun_zenith_deg, "Zenith angle of the sun")->check(CLI::Range(0.0, 180.0));
  command.add_option("--sun-azimuth-deg", a.sun_azimuth_deg, "Azimuth of the sun, clockwise from north")
      ->check(CLI::Range(-360.0, 360.0));
  command.add_option("--lat", a.lat, "Latitude, degrees north")->check(CLI::Range(-90.0, 90.0));
  command.add_option("--lon", a.lon, "Longitude, degrees east")->check(CLI::Range(-180.0, 180.0));
  command
      .add_option("--altitude-m", a.altitude_m,
                  "Altitude of the camera. Default: 0, and with --response auto sigma holds that it may be 500 m more")
      ->check(CLI::Range(-500.0, 9000.0));
  command.add_option("--utc", a.utc, "When the picture was taken, like 2018-01-29T11:09:20Z");
  command.add_flag("--sun-from-image", a.sun_from_image,
                   "Take the sun from where it is seen in the picture, also where time and place are given; default "
                   "where nothing else is known");
  command.add_flag("--allow-damaged", a.allow_damaged,
                   "Use what is left of damaged pictures, and say so; default: refuse them");
  command.add_option("--method", a.method, "free-gain, or the papers' single reference pixel")
      ->check(CLI::IsMember({"free-gain", "reference-pixel"}))
      ->capture_default_str();
  command
      .add_option("--sky-model", a.sky_model,
                  std::string(kSkyModelWords) + ". Default: auto; preetham with --method reference-pixel")
      ->type_name("MODEL");
  add_aerosol_options(command, a.aerosol);
  command.add_option("--samples", a.samples, "Number of sky pixels to sample")
      ->check(CLI::Range(60, 100000))
      ->capture_default_str();
  command.add_option("--seed", a.seed, "Seed of the random choice of pixels")->capture_default_str();
  auto* json = command.add_flag("--json", a.json, "One JSON object per line");
  command.add_flag("--csv", a.csv, "A table with a line for each picture, under a line of names")->excludes(json);
  command.add_flag("--plot", a.plot, "Write IMAGE.fit.png, fit against samples, next to each image");
  command.add_option("--plot-dir", a.plot_dir, "Write the plots into this folder instead");
  command.add_option("--jobs", a.jobs, "Pictures processed at a time (default: one per core)")
      ->check(CLI::Range(1, 1024));
  add_archive_options(command, a);
}

void order_lists(const CLI::App& command, EstimateRequest& arguments) {
  const auto* list = command.get_option("--list");
  const auto* image = command.get_option("image");
  std::vector<std::string> ordered;
  auto next_image = arguments.images.begin();
  auto next_list = arguments.lists.begin();
  for (const auto* option : command.parse_order()) {
    if (option == list && next_list != arguments.lists.end()) {
      ordered.push_back(*next_list == "-" ? "-" : "@" + *next_list);
      ++next_list;
    }
    if (option == image && next_image != arguments.images.end()) ordered.push_back(*next_image++);
  }
  arguments.images = std::move(ordered);
  arguments.lists.clear();
}

}  // namespace kasumi
