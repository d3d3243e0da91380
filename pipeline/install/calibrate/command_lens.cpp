#include <cmath>
#include <cstdio>
#include <set>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "calib/lens/import_lens.hpp"
#include "calib/lens/lens_calibration.hpp"
#include "pipeline/install/calibrate/board_options.hpp"
#include "pipeline/install/calibrate/board_session.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/machine/stop_signal.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

namespace {

struct LensArguments {
  std::vector<std::string> pictures;
  std::string config, live, size;  // instead of pictures: a live camera
  bool window = false;
  double seconds = 0.0;
  BoardOptions board;
  std::string import_file;
  std::string import_camera;
  std::string camera = "sky";
  std::string serial;
  std::string model = "auto";
  std::optional<double> largest_angle_deg;
  std::string out;
  std::vector<std::string> without_effect;  // options typed that --import does not use
};

std::optional<LensFamily> family_of(const std::string& model) {
  for (const auto family : kLensFamilies)
    if (model == name_of(family)) return family;
  return std::nullopt;
}

Image<std::uint8_t> grey_of(const Image<Rgb8>& picture) {
  Image<std::uint8_t> grey(picture.width(), picture.height());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& p = picture.at(x, y);
      grey.at(x, y) = static_cast<std::uint8_t>((77 * p.r + 150 * p.g + 29 * p.b + 128) >> 8);
    }
  return grey;
}

// Now, to the second.
std::string utc_now() {
  const auto now = std::chrono::floor<std::chrono::seconds>(SystemClock().utc());
  return utc_text(now);
}

struct FoundViews {
  std::vector<BoardView> views;
  std::vector<std::string> without;  // pictures in which no board was found
  int width = 0, height = 0;
};

Result<FoundViews> find_boards(const LensArguments& arguments, const AnyBoard& board) {
  FoundViews found;
  Problems problems;
  for (const auto& file : arguments.pictures) {
    const auto photograph = read_photograph(file);
    if (!photograph) {
      problems.add("{}", photograph.error().message);
      continue;
    }
    const auto grey = grey_of(to_rgb8(*photograph));
    if (found.width == 0) {
      found.width = grey.width();
      found.height = grey.height();
    }
    if (grey.width() != found.width || grey.height() != found.height) {
      problems.add("{}: {} x {}, expected {} x {} like the first picture: one camera, one size", file, grey.width(),
                   grey.height(), found.width, found.height);
      continue;
    }
    const auto name = std::filesystem::path(file).filename().string();
    if (auto view = find_any_board(grey, board, name)) {
      view->picture = std::make_shared<Image<std::uint8_t>>(grey);
      fmt::print("  {}: {} corners\n", name, view->pixels.size());
      found.views.push_back(std::move(*view));
    } else {
      found.without.push_back(name);
      fmt::print("  {}: no {} was found\n", name, description_of(board));
    }
    std::fflush(stdout);
  }
  if (!problems.empty()) return fail(problems.fault());
  return found;
}

Result<FoundViews> gather_from_camera(const LensArguments& arguments, const AnyBoard& board) {
  SystemClock clock;
  auto source = arguments.config.empty() ? open_live(arguments.live, arguments.camera, arguments.size, clock)
                                         : open_configured(arguments.config, arguments.camera, clock);
  if (!source) return fail(source.error());
  fmt::print("{}: show the camera the {}, near and far, tilted; Ctrl-C stops early\n", (*source)->description(),
             description_of(board));
  BoardSessionControl options;
  options.window = arguments.window;
  options.longest = from_seconds(arguments.seconds);
  options.stop = stop_requested;
  options.say = [](const std::string& message) {
    fmt::print("{}\n", message);
    std::fflush(stdout);
  };
  auto gathered = gather_views(**source, board, clock, options);
  if (!gathered) return fail(gathered.error());
  fmt::print("{} views from {} frames; {}\n", gathered->views.size(), gathered->frames, gathered->ended);
  return FoundViews{std::move(gathered->views), {}, gathered->width, gathered->height};
}

void report(const LensCalibration& c) {
  for (const auto& candidate : c.candidates)
    if (candidate.held_out_rms_px)
      fmt::print("{:<15} {:.3f} px (rms) on views it was not fitted to\n", name_of(candidate.family),
                 *candidate.held_out_rms_px);
    else
      fmt::print("{:<15} does not fit\n", name_of(candidate.family));
  for (const auto& dropped : c.dropped) fmt::print("dropped {}: {}\n", dropped.name, dropped.reason);
  const auto centre = centre_of(c.fit.lens);
  fmt::print("\n{}, from {} views: rms {:.3f} px\n", model_name(c.fit.lens), c.views.size(), c.fit.rms_px);
  if (c.fit.sigma)
    fmt::print("focal length {:.2f} +- {:.2f} px, centre ({:.2f} +- {:.2f}, {:.2f} +- {:.2f})\n",
               focal_px_of(c.fit.lens), c.fit.sigma->focal_px, centre.x, c.fit.sigma->centre_px.x, centre.y,
               c.fit.sigma->centre_px.y);
  else
    fmt::print("focal length {:.2f} px, centre ({:.2f}, {:.2f}); the views do not determine every parameter\n",
               focal_px_of(c.fit.lens), centre.x, centre.y);
  fmt::print("corners up to {:.0f} deg off the axis, in {:.0f} % of the picture; lens used up to {:.0f} deg\n",
             to_degrees(c.coverage.farthest), 100.0 * c.coverage.covered, to_degrees(c.fit.lens.largest_angle));
  for (const auto& advice : c.coverage.advice) fmt::print("better: {}\n", advice);
}

Measured measured_of(const AnyBoard& board, const LensCalibration& c, const FoundViews& found, const std::string& now) {
  Measured measured{"lens", now, "", {}, {}};
  std::vector<std::string> names;
  for (const auto& view : c.views) names.push_back(view.name);
  measured.from = fmt::format("{} pictures of a {}: {}", names.size(), description_of(board), fmt::join(names, ", "));
  measured.numbers = {{"rms_px", c.fit.rms_px}};
  for (const auto& candidate : c.candidates)
    if (candidate.held_out_rms_px)
      measured.numbers.emplace_back(fmt::format("held_out_{}_px", name_of(candidate.family)),
                                    *candidate.held_out_rms_px);
  if (c.fit.sigma) {
    measured.numbers.emplace_back("focal_sigma_px", c.fit.sigma->focal_px);
    measured.numbers.emplace_back("centre_x_sigma_px", c.fit.sigma->centre_px.x);
    measured.numbers.emplace_back("centre_y_sigma_px", c.fit.sigma->centre_px.y);
  }
  measured.numbers.emplace_back("farthest_corner_deg", to_degrees(c.coverage.farthest));
  measured.numbers.emplace_back("covered", c.coverage.covered);
  for (const auto& name : found.without) measured.remarks.push_back(name + ": no board was found");
  for (const auto& dropped : c.dropped) measured.remarks.push_back(dropped.name + ": dropped, " + dropped.reason);
  for (const auto& advice : c.coverage.advice) measured.remarks.push_back(advice);
  return measured;
}

Result<int> write(const LensArguments& arguments, const CalibrationStep& step) {
  const auto written = write_calibration(arguments.out, step);
  if (!written) return fail(written.error());
  fmt::print("written: {}\n", arguments.out);
  if (written->backup) fmt::print("the previous file was kept as {}\n", written->backup->string());
  return 0;
}

CalibrationStep step_of(const LensArguments& arguments, int width, int height, const LensDescription& lens,
                        const std::string& now) {
  CalibrationStep step;
  step.camera = arguments.camera;
  step.width = width;
  step.height = height;
  step.serial = arguments.serial;
  step.lens = lens;
  step.calibrated_utc = now;
  return step;
}

// By which a wrong model or unit shows itself.
void print_landing(const ImportedLens& imported) {
  constexpr double kOff_deg = 60.0;
  const auto lens = make_lens(imported.lens);
  const double sine = std::sin(from_degrees(kOff_deg).value), cosine = std::cos(from_degrees(kOff_deg).value);
  std::vector<std::string> places;
  for (const auto& [side, ray] :
       {std::pair{"to the right", glm::dvec3{sine, 0.0, cosine}}, {"down", glm::dvec3{0.0, sine, cosine}}}) {
    const auto pixel = lens->project(ray);
    const bool inside = pixel && pixel->x >= -0.5 && pixel->y >= -0.5 && pixel->x < imported.width - 0.5 &&
                        pixel->y < imported.height - 0.5;
    places.push_back(pixel ? fmt::format("{} at ({:.1f}, {:.1f}){}", side, pixel->x, pixel->y,
                                         inside ? "" : ", outside of the picture")
                           : fmt::format("{} nowhere: beyond the model's reach", side));
  }
  fmt::print("a direction {:.0f} deg off the axis lands {}\n", kOff_deg, fmt::join(places, "; "));
}

Result<int> import(const LensArguments& arguments) {
  ImportRequest options{arguments.model, {}, arguments.import_camera};
  if (arguments.largest_angle_deg) options.largest_angle = from_degrees(*arguments.largest_angle_deg);
  const auto imported = import_lens(arguments.import_file, options);
  if (!imported) return fail(imported.error());
  if (arguments.camera == "scene" && !std::holds_alternative<PinholeParameters>(imported->lens.model))
    return fail(FaultKind::bad_input, "{}: {} {}: expected a pinhole, for the scene is drawn through one",
                arguments.import_file, imported->program, imported->foreign_model);
  const auto now = utc_now();
  auto step = step_of(arguments, imported->width, imported->height, imported->lens, now);
  Measured measured{"lens",
                    now,
                    fmt::format("imported from {}, as {} wrote it",
                                std::filesystem::path(arguments.import_file).filename().string(), imported->program),
                    {},
                    {}};
  if (imported->rms_px) measured.numbers.emplace_back("rms_px", *imported->rms_px);
  if (imported->moved_px > 0.0) measured.numbers.emplace_back("moved_px", imported->moved_px);
  step.measured.push_back(std::move(measured));
  fmt::print("{} of {} x {} pictures, from {}{}\n", model_name(imported->lens), imported->width, imported->height,
             imported->program, imported->foreign_model.empty() ? "" : "'s " + imported->foreign_model);
  if (imported->moved_px > 0.0) fmt::print("fitted to it: no pixel moves by more than {:.4f}\n", imported->moved_px);
  print_landing(*imported);
  return write(arguments, step);
}

Result<int> calibrate(const LensArguments& arguments) {
  Problems problems;
  const bool importing = !arguments.import_file.empty();
  const auto board = importing ? AnyBoard() : read_board(arguments.board, false, problems);
  const bool running = !arguments.config.empty() || !arguments.live.empty();
  if (!importing && !arguments.import_camera.empty())
    problems.add("--import-camera {}: has no effect without --import", arguments.import_camera);
  for (const auto& option : arguments.without_effect)
    if (importing) problems.add("{}: has no effect with --import", option);
  if (importing && !arguments.pictures.empty())
    problems.add("--import {}: expected either this or pictures, not both", arguments.import_file);
  if (running && (importing || !arguments.pictures.empty() || (!arguments.config.empty() && !arguments.live.empty())))
    problems.add("expected one of pictures, --config, --live and --import");
  if (!running && !importing && arguments.pictures.size() < kFewestViews)
    problems.add("{} pictures: expected at least {} of the board, 15 are better (or --config, --live, --import)",
                 arguments.pictures.size(), kFewestViews);
  if (arguments.camera == "scene" && (arguments.model == "opencv_fisheye" || arguments.model == "scaramuzza"))
    problems.add("--model {}: expected pinhole: the scene is drawn with a pinhole projection", arguments.model);
  if (!problems.empty()) return fail(problems.fault());
  if (importing) return import(arguments);

  const auto found = running ? gather_from_camera(arguments, board) : find_boards(arguments, board);
  if (!found) return fail(found.error());
  LensCalibrationRequest options;
  options.family = family_of(arguments.camera == "scene" ? "pinhole" : arguments.model);
  if (arguments.largest_angle_deg) options.largest_angle = from_degrees(*arguments.largest_angle_deg);
  const auto calibration = calibrate_lens(found->views, found->width, found->height, options);
  if (!calibration) return fail(calibration.error());
  report(*calibration);
  const auto now = utc_now();
  auto step = step_of(arguments, found->width, found->height, calibration->fit.lens, now);
  step.measured.push_back(measured_of(board, *calibration, *found, now));
  const auto title = fmt::format("{}: {}, rms {:.3f} px over {} views", arguments.camera,
                                 model_name(calibration->fit.lens), calibration->fit.rms_px, calibration->views.size());
  return save_calibration(arguments.out, std::move(step), plot_lens(*calibration, found->width, found->height, title));
}

}  // namespace

void add_calibrate_lens(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "lens", "The lens, from pictures of a checkerboard or ChArUco board, or from another program's file");
  auto arguments = std::make_shared<LensArguments>();
  auto& a = *arguments;
  command->add_option("picture", a.pictures, "Pictures of the board, held still, in every part of the frame");
  add_board_options(*command, a.board);
  command->add_option(
      "--import", a.import_file,
      "Import a calibration of OpenCV, ROS, Kalibr, ORB-SLAM, COLMAP, Agisoft, Hugin or OCamCalib instead");
  command->add_option("--import-camera", a.import_camera,
                      "Which camera of that file, where Kalibr or COLMAP wrote several: by name or number");
  command->add_option("--config", a.config, "Take pictures live from the camera in this kasumi.toml instead");
  command->add_option("--live", a.live, "Take pictures live from this Video4Linux device or recording instead");
  command->add_option("--size", a.size, "Size of the device's pictures")->type_name("WIDTHxHEIGHT");
  command->add_flag("--window", a.window, "Show the live picture and which parts of it the board has covered");
  command->add_option("--seconds", a.seconds, "Longest live session; 0: until the picture is covered")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command->add_option("--camera", a.camera, "The camera whose lens is measured")
      ->check(CLI::IsMember({"sky", "scene"}))
      ->capture_default_str();
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command
      ->add_option("--model", a.model,
                   "Lens model; auto: the one that predicts views it was not fitted to best, or that holds --import's")
      ->check(CLI::IsMember({"auto", "pinhole", "opencv_fisheye", "scaramuzza"}))
      ->capture_default_str();
  command
      ->add_option("--largest-angle-deg", a.largest_angle_deg,
                   "How far off the axis a fisheye is used; default: 5 deg beyond the farthest corner")
      ->check(CLI::Range(1.0, 180.0));
  command->add_option("--out", a.out, "The calibration file; an older one is kept as a backup")->required();
  command->callback([arguments, command, &action] {
    const std::set<std::string> used{"--import", "--import-camera",     "--camera", "--serial",
                                     "--model",  "--largest-angle-deg", "--out"};
    for (const auto* option : command->get_options())
      if (option->count() > 0 && !option->get_positional() && !used.contains(option->get_name()))
        arguments->without_effect.push_back(option->get_name());
    action = [arguments] { return calibrate(*arguments); };
  });
}

}  // namespace kasumi
