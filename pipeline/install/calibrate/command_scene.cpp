#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/install/calibration_report/scene_sights.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

namespace {

constexpr double kFocalSigmaOfADataSheet = 0.03;

struct SceneArguments {
  std::string sights;
  std::string picture;
  std::string serial;
  std::optional<double> focal_percent;
  double position_sigma_m = 1.0;
  std::string out;
};

std::string offset_text(const glm::dvec2& residual_px) {
  return fmt::format("{:.1f} px {} and {:.1f} px {}", std::abs(residual_px.x), residual_px.x < 0.0 ? "left" : "right",
                     std::abs(residual_px.y), residual_px.y < 0.0 ? "above" : "below");
}

// The sights left out, with their residuals.
std::vector<std::string> left_out(const SceneSights& sights, const ScenePose& pose) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < sights.landmarks.size(); ++i)
    if (!pose.used[i])
      lines.push_back(
          fmt::format("{}: left out: marked {} of where the other landmarks put it; the wrong object was "
                      "marked, or its coordinates are wrong",
                      sights.landmarks[i].name, offset_text(pose.residuals_px[i])));
  for (std::size_t i = 0; i < sights.horizon.size(); ++i)
    if (!pose.horizon_used[i])
      lines.push_back(fmt::format("horizon at ({:.0f}, {:.0f}): left out, {:.1f} px off", sights.horizon[i].pixel.x,
                                  sights.horizon[i].pixel.y, pose.horizon_residuals_px[i]));
  return lines;
}

std::vector<std::string> position_remarks(const ScenePose& pose, double sigma_m) {
  std::vector<std::string> lines;
  const double off_m = glm::length(pose.position_m);
  if (sigma_m > 0.0 && off_m > 3.0 * sigma_m)
    lines.push_back(
        fmt::format("the camera seems to stand {:.1f} m east, {:.1f} m north and {:.1f} m above the site "
                    "as it is given; correct [site] and calibrate again",
                    pose.position_m.x, pose.position_m.y, pose.position_m.z));
  return lines;
}

void report(const SceneSights& sights, const ScenePose& pose) {
  for (std::size_t i = 0; i < sights.landmarks.size(); ++i) {
    const auto& sight = sights.landmarks[i];
    fmt::print("  {:<28} {:>10}  {:+7.2f} {:+7.2f} px{}\n", sight.name, distance_text(sight), pose.residuals_px[i].x,
               pose.residuals_px[i].y, pose.used[i] ? "" : "  left out");
  }
  const auto angles = heading_pitch_roll(pose.to_world);
  const auto& sigma = pose.sigma;
  fmt::print("heading {:.4f} +- {:.4f}, pitch {:.4f} +- {:.4f}, roll {:.3f} +- {:.3f} deg\n",
             to_degrees(angles.heading), to_degrees(sigma.heading), to_degrees(angles.pitch), to_degrees(sigma.pitch),
             to_degrees(angles.roll), to_degrees(sigma.roll));
  fmt::print("focal length {:.2f} px +- {:.3f} % ({:+.3f} % from before)\n", focal_px_of(pose.lens),
             100.0 * sigma.scale, 100.0 * (pose.scale - 1.0));
  fmt::print("direction of every pixel +- {:.4f} deg; rms {:.2f} px, {:.1f} times what the sigmas predict\n",
             to_degrees(sigma.anywhere), pose.rms_px, pose.misfit);
}

CalibrationStep step_of(const SceneArguments& arguments, const SceneSights& sights, const ScenePose& pose,
                        const std::vector<std::string>& remarks, const std::string& now) {
  CalibrationStep step;
  step.camera = "scene";
  step.width = sights.width;
  step.height = sights.height;
  step.serial = arguments.serial;
  step.lens = pose.lens;
  step.to_world = pose.to_world;
  step.response = sights.response;
  step.site = sights.site;
  step.calibrated_utc = now;
  std::vector<std::string> names;
  for (const auto& sight : sights.landmarks) names.push_back(sight.name);
  const auto used = std::count(pose.used.begin(), pose.used.end(), true);
  Measured measured{"pose",
                    now,
                    fmt::format("{} of {} landmarks and sightings of {}: {}", used, names.size(),
                                std::filesystem::path(arguments.sights).filename().string(), fmt::join(names, ", ")),
                    {{"rms_px", pose.rms_px},
                     {"misfit", pose.misfit},
                     {"heading_sigma_deg", to_degrees(pose.sigma.heading)},
                     {"pitch_sigma_deg", to_degrees(pose.sigma.pitch)},
                     {"roll_sigma_deg", to_degrees(pose.sigma.roll)},
                     {"anywhere_sigma_deg", to_degrees(pose.sigma.anywhere)},
                     {"focal_sigma_percent", 100.0 * pose.sigma.scale},
                     {"focal_scale", pose.scale},
                     {"refraction", sights.refraction}},
                    remarks};
  if (!sights.horizon.empty()) measured.from += fmt::format("; {} points of the horizon", sights.horizon.size());
  step.measured.push_back(std::move(measured));
  return step;
}

Result<int> calibrate(const SceneArguments& arguments) {
  Problems problems;
  const auto before = read_calibrated_scene(arguments.out);
  if (!before) problems.add("{}", before.error().message);
  const auto photograph = read_photograph(arguments.picture);
  if (!photograph) problems.add("{}", photograph.error().message);
  const auto sights = before ? read_scene_sights(arguments.sights, *before) : Result<SceneSights>();
  if (!sights) problems.add("{}", sights.error().message);
  if (photograph && before && sights &&
      (photograph->encoded.width() != sights->width || photograph->encoded.height() != sights->height))
    problems.add("{}: {} x {}, expected {} x {} as the description of the camera says", arguments.picture,
                 photograph->encoded.width(), photograph->encoded.height(), sights->width, sights->height);
  if (!problems.empty()) return fail(problems.fault());

  ScenePrior prior;
  prior.width = sights->width;
  prior.height = sights->height;
  prior.lens = sights->lens;
  prior.scale_sigma =
      arguments.focal_percent ? 0.01 * *arguments.focal_percent : before->focal_sigma.value_or(kFocalSigmaOfADataSheet);
  prior.position_sigma_m = arguments.position_sigma_m;
  const auto pose = pose_scene(sights->landmarks, sights->horizon, prior);
  if (!pose) return fail(pose.error().kind, "{}: {}", arguments.sights, pose.error().message);
  report(*sights, *pose);
  auto remarks = left_out(*sights, *pose);
  for (const auto& remark : remarks) fmt::print("{}\n", remark);
  for (const auto& remark : position_remarks(*pose, arguments.position_sigma_m)) {
    fmt::print("{}\n", remark);
    remarks.push_back(remark);
  }
  for (const auto& remark : pose->undetermined) {
    fmt::print("undetermined: {}\n", remark);
    remarks.push_back("undetermined: " + remark);
  }

  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  const auto step = step_of(arguments, *sights, *pose, remarks, now);
  const auto title = fmt::format("rms {:.2f} px; every pixel's direction +- {:.4f} deg", pose->rms_px,
                                 to_degrees(pose->sigma.anywhere));
  return save_calibration(arguments.out, step,
                          plot_scene(to_rgb8(*photograph), sights->landmarks, sights->horizon, *pose, title));
}

}  // namespace

void add_calibrate_scene(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "scene", "Where the scene camera looks, from landmarks and the sun in its pictures");
  auto arguments = std::make_shared<SceneArguments>();
  auto& a = *arguments;
  command
      ->add_option(
          "landmarks", a.sights,
          "TOML: landmarks with their coordinates, or the sun with its time, and their pixels (docs/calibration.md)")
      ->required();
  command->add_option("--picture", a.picture, "The picture in which the landmarks were marked")->required();
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command
      ->add_option("--focal-percent", a.focal_percent,
                   "Uncertainty of the focal length; 0: fixed; default: as calibrate lens measured it, or 3")
      ->check(CLI::Range(0.0, 30.0));
  command->add_option("--site-m", a.position_sigma_m, "Uncertainty of the camera's position along each axis; 0: fixed")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--out", a.out,
                   "The calibration file; its site and lens are used, and an older file is kept as a backup")
      ->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi
