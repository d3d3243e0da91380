#include <cstdlib>
#include <filesystem>
#include <memory>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/lab/haze/haze_maker.hpp"
#include "pipeline/lab/haze/haze_window.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

struct HazeArguments {
  HazeOptions options;
  std::string out, sheet, film;
  double frames_per_second = 10.0;
  bool on_cpu = false, live = false;
};

Result<int> show_live(const HazeTask& task) {
  if (task.scheme == DiffusionScheme::invariant)
    return fail(FaultKind::bad_input, "--live: expected --scheme matched or explicit, which run on the GPU");
  auto window = HazeWindow::open(task);
  if (!window) return fail(window.error());
  for (;;) {
    const auto open = window->step();
    if (!open) return fail(open.error());
    if (!*open) break;
  }
  fmt::print("{}\n", caption_of(window->values()));
  return 0;
}

Result<> make_pictures(const HazeArguments& a, const HazeTask& task) {
  const bool alone = task.values.size() == 1;
  if (!alone && !a.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(a.out, error);
    if (error)
      return fail(FaultKind::bad_input, "--out {}: expected a folder, for several pictures ({})", a.out,
                  error.message());
  }
  auto maker = HazeMaker::create(task, a.on_cpu);
  if (!maker) return fail(maker.error());
  ContactSheet sheet;
  if (!a.sheet.empty()) sheet.add(to_rgb8(task.photograph), "as taken");
  std::unique_ptr<PictureSink> film;
  if (!a.film.empty()) {
    auto opened = open_film(a.film, a.frames_per_second);
    if (!opened) return fail(opened.error());
    film = std::move(*opened);
  }
  for (const auto& haze : task.values) {
    const auto made = maker->make(haze);
    if (!made) return fail(made.error());
    if (!a.out.empty()) {
      const auto name = std::filesystem::path(a.options.picture).stem().string();
      const std::filesystem::path place =
          alone ? std::filesystem::path(a.out)
                : std::filesystem::path(a.out) / fmt::format("{}.{}.png", name, haze.name());
      if (auto done = write_photograph(place, made->picture); !done) return done;
      fmt::print("{}: {}, {} passes, {:.0f} operations a pixel, {}\n", place.string(), name_of(task.scheme),
                 made->cost.passes, made->cost.operations(), maker->device());
    }
    const auto pixels = to_rgb8(made->picture);
    if (!a.sheet.empty()) sheet.add(pixels, haze.name());
    if (film)
      if (auto done = film->put(pixels); !done) return done;
  }
  if (film)
    if (auto done = film->finish(); !done) return done;
  if (!a.sheet.empty()) return sheet.write(a.sheet);
  return {};
}

Result<int> make_haze(const HazeArguments& a) {
  // OpenCV reads EXR only when this variable is set.
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
  const auto task = haze_task(a.options);
  if (!task) return fail(task.error());
  fmt::print("range to {:.4g} m; {} holes filled ({:.1f} % of the picture), sky {:.1f} %\n", task->range.farthest_m,
             task->range.holes, 100.0 * task->range.hole_share, 100.0 * task->range.sky_share);
  if (a.live) return show_live(*task);
  if (auto done = make_pictures(a, *task); !done) return fail(done.error());
  return 0;
}

}  // namespace

void add_haze_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("haze", "Dense haze over a photograph, with blur as well as attenuation");
  auto arguments = std::make_shared<HazeArguments>();
  auto& a = *arguments;
  auto& options = a.options;
  command->add_option("picture", options.picture, "The picture")->required();
  add_distance_options(*command, options.distances, "not known");
  command->add_flag("--indoors", options.indoors,
                    "There is no sky: every unknown region is a hole, and the airlight may come from bright walls");
  command
      ->add_option("--sky-share", options.range.smallest_sky_share,
                   "Unknown regions of at least this share of the picture are sky, smaller ones are holes")
      ->check(CLI::Range(1e-6, 1.0))
      ->capture_default_str();
  command->add_option("--sky-range", options.range.sky_range, "Distance of the sky, in multiples of the farthest range")
      ->check(CLI::Range(1.001, 10.0))
      ->capture_default_str();
  command->add_option("--margin-px", options.range.margin_px, "Width of the transition from the scene to the sky")
      ->check(CLI::Range(0, 200))
      ->capture_default_str();
  command
      ->add_option("--outline-reach-px", options.outline_reach_px,
                   "How far outlines of the distances may lie from the picture's edges, to which they are moved; 0: "
                   "they stay; default: a hundredth of the width")
      ->check(CLI::Range(0, 64));
  command->add_flag("--cut-outlines", options.cut_outlines,
                    "Let no light cross an outline: things keep razor edges however far they are");
  command->add_option("--turbidity", options.turbidities, "T of the haze: 8, or FROM:TO:STEP; several with commas")
      ->delimiter(',');
  command
      ->add_option("--aod", options.aods,
                   "Instead of T: aerosol optical depth at 550 nm, or FROM:TO:STEP; several with commas")
      ->delimiter(',');
  add_aerosol_options(*command, options.aerosol);
  command
      ->add_option("--kappa-s", options.scatterings,
                   "Instead of T: scattering per farthest range (H), or FROM:TO:STEP; several with commas")
      ->delimiter(',');
  command->add_option("--kappa-a", options.kappa_a, "With --kappa-s: absorption per farthest range")
      ->check(CLI::Range(0.0, 100.0));
  command->add_option("--lambda", options.lambda, "The widest blur is lambda sqrt(kappa_s), in pixels")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command->add_option("--airlight", options.airlight, "Light from infinity, linear; default: measured at the horizon")
      ->type_name("R,G,B")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(1e-3, 4.0));
  command->add_option("--sensitivity", options.sensitivity,
                      "The camera's spectral sensitivity (JSON or CSV), with --turbidity");
  command
      ->add_option("--scattering", options.scattering,
                   "Scattering coefficients, with --turbidity or --aod; auto: the aerosol's where it is known, else "
                   "morales2017")
      ->check(CLI::IsMember({"auto", "morales2017", "preetham", "zhao", "aerosol"}))
      ->capture_default_str();
  command->add_option("--altitude-m", options.altitude_m, "Altitude of the camera, with --turbidity")
      ->check(CLI::Range(-500.0, 9000.0))
      ->capture_default_str();
  command->add_option("--fov-deg", options.field_of_view_deg, "Horizontal field of view, to measure the airlight")
      ->check(CLI::Range(0.5, 150.0))
      ->capture_default_str();
  command->add_option("--pitch-deg", options.pitch_deg, "Elevation of the picture's centre, to measure the airlight")
      ->check(CLI::Range(-60.0, 60.0))
      ->capture_default_str();
  command->add_option("--scheme", options.scheme, "Blur scheme: ours (matched), or one of the paper's")
      ->check(CLI::IsMember({"matched", "explicit", "invariant"}))
      ->capture_default_str();
  command->add_flag("--allow-damaged", options.allow_damaged,
                    "Use what is left of a damaged picture, and say so; default: refuse it");
  command->add_flag("--cpu", a.on_cpu, "Compute on the CPU (the reference implementation)");
  command->add_flag("--live", a.live, "In a window, with keys that change the haze");
  command->add_option("--out", a.out, "Picture to write; a folder for several");
  command->add_option("--sheet", a.sheet, "Contact sheet of all pictures, as PNG");
  command->add_option("--film", a.film, "All pictures as a film")->type_name("FILE");
  command->add_option("--fps", a.frames_per_second, "Frame rate of the film")
      ->check(CLI::Range(0.1, 120.0))
      ->capture_default_str();
  command->callback([arguments, &action] {
    const auto& given = *arguments;
    if (given.out.empty() && given.sheet.empty() && given.film.empty() && !given.live)
      throw CLI::ValidationError("--out, --sheet, --film, --live", "expected at least one of them");
    action = [arguments] { return make_haze(*arguments); };
  });
}

}  // namespace kasumi
