#include <cmath>
#include <cstdio>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calib/adopt_calibration.hpp"
#include "capture/utc_text.hpp"
#include "pipeline/command.hpp"
#include "pipeline/fit_plot.hpp"
#include "pipeline/ordered_jobs.hpp"
#include "pipeline/picture_sink.hpp"
#include "pipeline/scene_visibility.hpp"
#include "pipeline/sky_photograph.hpp"

namespace kasumi {

namespace {

struct EstimateArguments {
  std::vector<std::string> images;
  std::vector<std::string> scenes;  // of the scene camera
  std::string landmarks;
  std::string calibration;
  std::string lens = "equidistant";
  double fov_deg = 180.0;
  std::vector<double> circle;
  double azimuth_up_deg = 0.0;
  std::string response = "srgb";
  std::optional<double> sun_zenith_deg, sun_azimuth_deg, lat, lon;
  double altitude_m = 0.0;
  std::string utc;
  bool sun_from_image = false;
  std::string method = "free-gain";
  std::string sky_model = "preetham";
  int samples = EstimateOptions{}.samples;
  std::uint64_t seed = 1;
  bool json = false;
  bool plot = false;
  std::string plot_dir;
  std::size_t jobs = 0;

  bool from_stdin() const { return (images.empty() && scenes.empty()) || images == std::vector<std::string>{"-"}; }
};

Result<> read_calibration(const std::string& file, SkyPhotographSetup& setup) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  if (root->has("format")) adopt_calibration(*root);  // a fixture's description, which may name one
  if (auto site = root->optional_table("site")) setup.site = read_site(*site);
  setup.calibrated = read_camera(root->table("sky"), "sky");
  // What kasumi calibrate wrote serves, and so does a fixture's description as it is.
  for (const char* key :
       {"calibration", "format", "name", "description", "licence", "provenance", "start_utc", "scene", "object"})
    root->ignore(key);
  return root->finish();
}

// Where the sun stood: exactly one way of telling.
void read_sun(const EstimateArguments& arguments, SkyPhotographSetup& setup, Problems& problems) {
  if (arguments.sun_zenith_deg.has_value() != arguments.sun_azimuth_deg.has_value())
    problems.add("--sun-zenith-deg and --sun-azimuth-deg: expected both or neither");
  if (arguments.lat.has_value() != arguments.lon.has_value()) problems.add("--lat and --lon: expected both or neither");
  if (arguments.sun_zenith_deg && arguments.sun_azimuth_deg)
    setup.sun = direction_from(from_degrees(*arguments.sun_zenith_deg), from_degrees(*arguments.sun_azimuth_deg));
  if (arguments.lat && arguments.lon) setup.site = Site{"", *arguments.lat, *arguments.lon, arguments.altitude_m};
  if (!arguments.utc.empty()) {
    setup.utc = parse_utc(arguments.utc);
    if (!setup.utc) problems.add("--utc {}: expected a time like 2018-01-29T11:09:20Z", arguments.utc);
  }
  setup.sun_from_image = arguments.sun_from_image;
  if (setup.sun && setup.utc)
    problems.add("--utc and --sun-zenith-deg: expected one of them, each tells where the sun stood");
  const bool times_may_follow = arguments.from_stdin() && setup.site;
  if (!setup.sun && !(setup.site && (setup.utc || times_may_follow)) && !setup.sun_from_image)
    problems.add(
        "where the sun stood is not known: expected --sun-zenith-deg and --sun-azimuth-deg, or --utc with --lat "
        "and --lon (or a --calibration with [site]), or --sun-from-image");
}

Result<SkyPhotographSetup> setup_of(const EstimateArguments& arguments) {
  SkyPhotographSetup setup;
  Problems problems;
  if (!arguments.calibration.empty())
    if (auto read = read_calibration(arguments.calibration, setup); !read) problems.add("{}", read.error().message);
  setup.equisolid = arguments.lens == "equisolid";
  setup.field_of_view = from_degrees(arguments.fov_deg);
  if (!arguments.circle.empty()) {
    if (arguments.circle[2] > 0.0)
      setup.circle = ImageCircle{{arguments.circle[0], arguments.circle[1]}, arguments.circle[2]};
    else
      problems.add("--circle: radius {} px, expected more than 0", arguments.circle[2]);
  }
  setup.azimuth_up = from_degrees(arguments.azimuth_up_deg);
  setup.linear_response = arguments.response == "linear";
  read_sun(arguments, setup, problems);
  setup.estimate.method =
      arguments.method == "reference-pixel" ? EstimateMethod::reference_pixel : EstimateMethod::free_gain;
  const double altitude_m = setup.site ? setup.site->altitude_m : arguments.altitude_m;
  setup.estimate.sky = {resolved(*site_sky_model_named(arguments.sky_model), altitude_m), altitude_m};
  if (setup.estimate.method == EstimateMethod::reference_pixel && setup.estimate.sky.model == SiteSkyModel::dome)
    problems.add("--method reference-pixel: the papers' way fits the papers' sky, expected --sky-model preetham");
  setup.estimate.samples = arguments.samples;
  setup.estimate.seed = arguments.seed;
  if (!problems.empty()) return fail(problems.fault());
  return setup;
}

struct ImageJob {
  std::filesystem::path file;
  std::optional<Utc> utc;
  std::string problem;                     // of a line of the list
  const SceneVisibility* scene = nullptr;  // taken at the same time
};

// One line of a list: a path, or a path, a tab and a UTC time.
ImageJob job_of(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  ImageJob job;
  const auto tab = line.find('\t');
  job.file = line.substr(0, tab);
  if (tab != std::string::npos) {
    job.utc = parse_utc(line.substr(tab + 1));
    if (!job.utc)
      job.problem = fmt::format("{}: time '{}': expected a time like 2018-01-29T11:09:20Z", job.file.string(),
                                line.substr(tab + 1));
  }
  return job;
}

// What the landmarks in the scene camera's picture of the same time say, beside the sky.
std::string landmarks_of(const SceneVisibilities& scenes, const SceneVisibility& scene,
                         const SkyPhotographReport* report, bool json) {
  std::optional<SkyComparison> sky;
  if (report && report->look.estimate.usable)
    sky = scenes.watch.compare(scene.air, report->look.estimate.turbidity, report->look.estimate.sigma);
  return json ? visibility_json(scenes.watch, scene, sky ? &*sky : nullptr)
              : visibility_text(scenes.watch, scene, sky ? &*sky : nullptr);
}

nlohmann::ordered_json json_of(const ImageJob& job, const SkyPhotographReport& report) {
  const auto& estimate = report.look.estimate;
  // Dividing by a power of ten gives the double that prints with so many digits; multiplying by its inverse does not.
  const auto rounded = [](double value, int digits) {
    const double scale = std::pow(10.0, digits);
    return std::round(value * scale) / scale;
  };
  nlohmann::ordered_json json;
  json["image"] = job.file.string();
  json["turbidity"] = nullptr;
  json["sigma"] = nullptr;
  if (estimate.usable) {
    json["turbidity"] = rounded(estimate.turbidity.value, 5);
    json["sigma"] = rounded(estimate.sigma, 6);
  }
  json["usable"] = estimate.usable;
  json["reason"] = estimate.reason;
  json["sky"] = name_of(estimate.sky);
  json["clear_fraction"] = rounded(estimate.clear_fraction, 4);
  json["samples"] = estimate.samples;
  json["log_residual"] = rounded(estimate.log_residual, 5);
  json["sky_model"] = name_of(report.look.sky.model);
  json["sun_zenith_deg"] = nullptr;
  json["sun_azimuth_deg"] = nullptr;
  if (report.sun) {
    json["sun_zenith_deg"] = rounded(to_degrees(zenith_angle(*report.sun)), 4);
    json["sun_azimuth_deg"] = rounded(to_degrees(azimuth_angle(*report.sun)), 4);
  }
  json["sun_from"] = report.sun_words;
  json["aod_550"] = nullptr;
  json["visibility_m"] = nullptr;
  json["weather"] = nullptr;
  if (report.air) {
    json["aod_550"] = rounded(report.air->aod_550, 5);
    json["visibility_m"] = rounded(report.air->visibility_m, 0);
    json["weather"] = name_of(report.air->weather);
  }
  if (report.circle)
    json["circle"] = {rounded(report.circle->centre.x, 2), rounded(report.circle->centre.y, 2),
                      rounded(report.circle->radius_px, 2)};
  return json;
}

std::string text_of(const ImageJob& job, const SkyPhotographReport& report) {
  const auto& estimate = report.look.estimate;
  std::string text = job.file.string() + "\n";
  if (estimate.usable && report.air) {
    text += fmt::format("  turbidity        {:.3f} +- {:.3f}{}\n", estimate.turbidity.value, estimate.sigma,
                        report.look.sky.model == SiteSkyModel::dome
                            ? fmt::format(" (of the dome, seen from {:.0f} m)", report.look.sky.altitude_m)
                            : "");
    text += fmt::format("  aerosol depth    {:.3f} at 550 nm\n", report.air->aod_550);
    text += fmt::format("  visibility       {:.1f} km\n", report.air->visibility_m / 1000.0);
    text += fmt::format("  weather          {}\n", name_of(report.air->weather));
  } else {
    text += fmt::format("  not usable       {}\n", estimate.reason);
  }
  text += fmt::format("  sky              {}, {:.0f} % of what was looked at is clear\n", name_of(estimate.sky),
                      100.0 * estimate.clear_fraction);
  if (report.sun)
    text += fmt::format("  sun              zenith {:.2f} deg, azimuth {:.2f} deg{}\n",
                        to_degrees(zenith_angle(*report.sun)), to_degrees(azimuth_angle(*report.sun)),
                        report.sun_words.empty() ? "" : " (" + report.sun_words + ")");
  if (estimate.usable)
    text += fmt::format("  fit              {} samples agree within {:.1f} % (rms)\n", estimate.samples,
                        100.0 * estimate.log_residual);
  if (report.circle)
    text += fmt::format("  image circle     centre ({:.1f}, {:.1f}), radius {:.1f} px\n", report.circle->centre.x,
                        report.circle->centre.y, report.circle->radius_px);
  return text;
}

std::filesystem::path plot_path(const EstimateArguments& arguments, const std::filesystem::path& image) {
  auto name = image.filename();
  name += ".fit.png";
  return (arguments.plot_dir.empty() ? image.parent_path() : std::filesystem::path(arguments.plot_dir)) / name;
}

struct Answer {
  std::string text;   // for standard output
  std::string error;  // for standard error
};

Answer answer_of(const EstimateArguments& arguments, SkyPhotographs& photographs, const SceneVisibilities* scenes,
                 const ImageJob& job) {
  if (!job.problem.empty()) return {"", job.problem};
  const auto report = photographs.look_at(job.file, job.utc);
  if (!report) return {"", report.error().message};
  const auto beside = job.scene ? landmarks_of(*scenes, *job.scene, &*report, arguments.json) : std::string();
  Answer answer;
  if (arguments.json) {
    auto json = json_of(job, *report);
    if (job.scene) json["landmarks"] = nlohmann::ordered_json::parse(beside);
    answer.text = json.dump() + "\n";
  } else {
    answer.text = text_of(job, *report) + beside;
  }
  if ((arguments.plot || !arguments.plot_dir.empty()) && report->picture) {
    const auto path = plot_path(arguments, job.file);
    const auto& estimate = report->look.estimate;
    const auto title = estimate.usable ? fmt::format("{}: T = {:.3f} +- {:.3f}", job.file.filename().string(),
                                                     estimate.turbidity.value, estimate.sigma)
                                       : fmt::format("{}: {}", job.file.filename().string(), estimate.reason);
    if (auto written = write_png(path, plot_fit(*report->picture, report->look, title)); !written)
      answer.error = written.error().message;
  }
  return answer;
}

Result<int> estimate(const EstimateArguments& arguments) {
  std::optional<SceneVisibilities> scenes;
  if (!arguments.scenes.empty()) {
    auto looked = look_at_scenes({arguments.scenes.begin(), arguments.scenes.end()}, arguments.landmarks);
    if (!looked) return fail(looked.error());
    scenes = std::move(*looked);
    if (arguments.images.empty()) {
      for (const auto& scene : scenes->pictures)
        fmt::print("{}{}", landmarks_of(*scenes, scene, nullptr, arguments.json), arguments.json ? "\n" : "");
      return 0;
    }
    if (arguments.from_stdin() || scenes->pictures.size() != arguments.images.size())
      return fail(
          FaultKind::bad_input,
          "--scene: {} pictures beside {} of the sky: expected one for each, in their order, or none of the sky",
          scenes->pictures.size(), arguments.from_stdin() ? 0 : arguments.images.size());
  }
  const auto setup = setup_of(arguments);
  if (!setup) return fail(setup.error());

  std::size_t given = 0;
  const auto next = [&]() -> std::optional<ImageJob> {
    if (!arguments.from_stdin()) {
      if (given == arguments.images.size()) return std::nullopt;
      const auto at = given++;
      return ImageJob{arguments.images[at], std::nullopt, "", scenes ? &scenes->pictures[at] : nullptr};
    }
    for (std::string line; std::getline(std::cin, line);)
      if (!line.empty()) return job_of(std::move(line));
    return std::nullopt;
  };

  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::size_t threads = arguments.jobs > 0 ? arguments.jobs : cores;
  if (!arguments.from_stdin()) threads = std::min(threads, arguments.images.size());
  std::vector<SkyPhotographs> workers;
  for (std::size_t i = 0; i < threads; ++i) workers.emplace_back(*setup);

  bool all_read = true;
  run_in_order<ImageJob, Answer>(
      threads, next,
      [&](std::size_t worker, const ImageJob& job) {
        return answer_of(arguments, workers[worker], scenes ? &*scenes : nullptr, job);
      },
      [&](const ImageJob&, const Answer& answer) {
        fmt::print("{}", answer.text);
        std::fflush(stdout);
        if (answer.error.empty()) return;
        fmt::print(stderr, "kasumi: {}\n", answer.error);
        all_read = false;
      });
  return all_read ? 0 : 2;
}

}  // namespace

void add_estimate_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("estimate", "Turbidity from photographs of the sky");
  auto arguments = std::make_shared<EstimateArguments>();
  auto& a = *arguments;
  command->add_option(
      "image", a.images,
      "Pictures; none or -: a list on standard input, one path a line, with a tab and its UTC where known");
  auto* scene = command->add_option(
      "--scene", a.scenes,
      "Pictures of the scene camera, or a folder: visibility from --landmarks; beside as many of the sky");
  command->add_option("--landmarks", a.landmarks, "TOML of [[landmarks]] at known distance (docs/operating.md)")
      ->check(CLI::ExistingFile)
      ->needs(scene);
  command->add_option("--calibration", a.calibration,
                      "TOML with [sky] (docs/cameras.md) and, if wanted, [site]; instead of the lens options");
  command->add_option("--lens", a.lens, "Fisheye model")
      ->check(CLI::IsMember({"equidistant", "equisolid"}))
      ->capture_default_str();
  command->add_option("--fov-deg", a.fov_deg, "Field of view across the image circle")
      ->check(CLI::Range(60.0, 250.0))
      ->capture_default_str();
  command
      ->add_option("--circle", a.circle,
                   "Image circle in pixels: centre and radius; found in the picture when left out")
      ->type_name("CX,CY,R")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option("--azimuth-up-deg", a.azimuth_up_deg, "Azimuth of the image's top; azimuth grows counter-clockwise")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command->add_option("--response", a.response, "What the numbers mean")
      ->check(CLI::IsMember({"srgb", "linear"}))
      ->capture_default_str();
  command->add_option("--sun-zenith-deg", a.sun_zenith_deg, "Zenith angle of the sun")->check(CLI::Range(0.0, 180.0));
  command->add_option("--sun-azimuth-deg", a.sun_azimuth_deg, "Azimuth of the sun, clockwise from north")
      ->check(CLI::Range(-360.0, 360.0));
  command->add_option("--lat", a.lat, "Latitude, degrees north")->check(CLI::Range(-90.0, 90.0));
  command->add_option("--lon", a.lon, "Longitude, degrees east")->check(CLI::Range(-180.0, 180.0));
  command->add_option("--altitude-m", a.altitude_m, "Altitude of the camera")
      ->check(CLI::Range(-500.0, 9000.0))
      ->capture_default_str();
  command->add_option("--utc", a.utc, "When the picture was taken, like 2018-01-29T11:09:20Z");
  command->add_flag("--sun-from-image", a.sun_from_image, "Find the sun as the saturated blob in the picture");
  command->add_option("--method", a.method, "free-gain, or the papers' single reference pixel")
      ->check(CLI::IsMember({"free-gain", "reference-pixel"}))
      ->capture_default_str();
  command
      ->add_option("--sky-model", a.sky_model,
                   "The clear sky whose turbidity is found: the papers', or the dome seen from --altitude-m or the "
                   "calibration's site (docs/sky.md); automatic: the dome above 1500 m")
      ->check(CLI::IsMember({"preetham", "dome", "automatic"}))
      ->capture_default_str();
  command->add_option("--samples", a.samples, "Sky pixels that are looked at")
      ->check(CLI::Range(60, 100000))
      ->capture_default_str();
  command->add_option("--seed", a.seed, "Of the choice of pixels")->capture_default_str();
  command->add_flag("--json", a.json, "One JSON object a line");
  command->add_flag("--plot", a.plot, "Write IMAGE.fit.png, fit against samples, beside each image");
  command->add_option("--plot-dir", a.plot_dir, "Write the plots into this folder instead");
  command->add_option("--jobs", a.jobs, "Pictures worked on at a time (all cores when left out)")
      ->check(CLI::Range(1, 1024));
  command->callback([arguments, &action] {
    if (!arguments->scenes.empty() && arguments->landmarks.empty())
      throw CLI::ValidationError("--scene", "expected --landmarks FILE, where they are and how far");
    action = [arguments] { return estimate(*arguments); };
  });
}

}  // namespace kasumi
