#include <malloc.h>

#include <algorithm>
#include <cstdio>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/air_options.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/recording/replay.hpp"

namespace kasumi {

namespace {

struct ReplayArguments {
  std::string fixture;
  std::string out;
  bool window = false;
  bool realtime = false;
  std::size_t frames = 0;
  double turbidity = 0.0;
  AirOptions air;
  bool no_aerial_perspective = false;
  bool terms = false;
  bool overlay = false;
  std::string mixing = "auto";
  double wipe = 0.0;
  std::string view = "live";
  std::string scattering = "auto";
  std::string zeta = "full";
};

ReplayRequest request_of(const ReplayArguments& arguments) {
  ReplayRequest request;
  request.fixture = arguments.fixture;
  if (!arguments.out.empty()) request.out = arguments.out;
  request.window = arguments.window;
  request.realtime = arguments.realtime;
  if (arguments.frames > 0) request.frames = arguments.frames;
  if (arguments.turbidity > 0.0) request.air.turbidity = Turbidity{arguments.turbidity};
  request.air.aerial_perspective = !arguments.no_aerial_perspective;
  request.air.scattering = scattering_model_named(arguments.scattering);
  request.given = arguments.air.given();
  request.air.zeta = *zeta_form_named(arguments.zeta);
  request.terms = arguments.terms;
  request.overlay = arguments.overlay;
  if (arguments.mixing == "gpu") request.mixing = Mixing::gpu;
  if (arguments.mixing == "processor") request.mixing = Mixing::processor;
  request.wipe = arguments.wipe;
  request.view =
      static_cast<BuildingView>(std::ranges::find(kBuildingViewNames, arguments.view) - kBuildingViewNames.begin());
  return request;
}

void print(const ReplaySummary& summary, const ReplayRequest& request) {
  fmt::print("{}: {} pictures in {:.1f} s ({:.1f} a second) by {}{}\n", summary.fixture, summary.pictures,
             summary.seconds, static_cast<double>(summary.pictures) / summary.seconds, summary.gl_renderer,
             summary.software_gl ? " (software)" : "");
  if (summary.processor_mixed) fmt::print("pictures were mixed by the processor\n");
  fmt::print("time: {}{}\n", text_of(summary.stages, summary.pictures),
             request.realtime ? "" : "; side by side where they can be");
  if (summary.sighting.in_picture())
    fmt::print("{}\n", summary.sighting.message);
  else
    spdlog::warn("{}", summary.sighting.message);
  fmt::print("sky: {} frames, {} usable\n", summary.sky_frames, summary.usable_sky_frames);
  if (summary.given) {
    fmt::print("air: {}, as given\n", text_of(*summary.given));
  } else if (summary.air) {
    const TrackedAir& tracked = *summary.last->air;
    fmt::print("turbidity: {:.2f} +- {:.2f}, aerosol optical depth {:.3f}, visibility {:.1f} km, {}\n",
               tracked.air.turbidity().value, tracked.sigma_turbidity, summary.air->aod_550,
               summary.air->visibility_m / 1000.0, name_of(summary.air->weather));
    if (const auto& aerosol = summary.air->aerosol) fmt::print("air: {}\n", text_of(*aerosol));
    fmt::print("{}\n", tracked.text());
  } else if (!request.air.turbidity && summary.last && summary.last->air) {
    fmt::print("turbidity: unknown ({}); {}\n", summary.last->estimate.reason, summary.last->air->text());
  } else if (!request.air.turbidity) {
    fmt::print("turbidity: unknown; {:.1f} was assumed{}\n", request.air.until_known.value,
               summary.last ? " (" + summary.last->estimate.reason + ")" : "");
  }
  if (request.air.turbidity) fmt::print("drawn at turbidity {:.2f}, as requested\n", request.air.turbidity->value);
  fmt::print("airlight: {}{}\n", name_of(summary.horizon),
             summary.horizon_reason.empty() ? "" : ", " + summary.horizon_reason);
  fmt::print("the building was redrawn {} times\n", summary.layers_drawn);
  for (const auto& [reason, count] : summary.skipped) fmt::print("skipped: {} x {}\n", count, reason);
  for (const auto& note : summary.notes) spdlog::info("{}", note);
  if (request.out) fmt::print("written: {}\n", request.out->string());
}

std::string why_none(const ReplaySummary& summary) {
  std::string why;
  for (const auto& [reason, count] : summary.skipped)
    if (reason.starts_with("scene camera")) why += fmt::format("{}{} x {}", why.empty() ? "" : "; ", count, reason);
  return why.empty() ? "the scene camera's recording has no frame" : why;
}

}  // namespace

void add_replay_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("replay", "Play a fixture through the whole pipeline");
  auto arguments = std::make_shared<ReplayArguments>();
  command->add_option("fixture", arguments->fixture, "Folder with fixture.toml, sky/ and scene/")->required();
  command->add_option("--out", arguments->out, "Folder for PNGs and turbidity.csv, or FILE.mp4");
  command->add_flag("--window", arguments->window, "Show the pictures in a window (Escape closes it)");
  command->add_option("--frames", arguments->frames, "At most N pictures")->check(CLI::Range(1, 1'000'000'000));
  command->add_flag("--realtime", arguments->realtime, "At the recorded pace instead of as fast as possible");
  auto* turbidity =
      command->add_option("--turbidity", arguments->turbidity, "Draw the building under this T instead of the sky's")
          ->check(CLI::Range(kLowestTurbidity.value, kHighestTurbidity.value));
  add_air_options(*command, arguments->air, "Aerosol optical depth at 550 nm, where it is known: instead of T");
  turbidity->excludes(command->get_option("--aod"));
  command->add_flag("--no-aerial-perspective", arguments->no_aerial_perspective,
                    "Draw the building as if there were no air in between");
  command->add_flag("--terms", arguments->terms,
                    "Next to each picture of a folder its airlight and its direct transmission, which add up to it");
  command->add_flag("--overlay", arguments->overlay,
                    "Draw a grid of directions, the horizon, the building's axes and the landmarks over the pictures");
  command
      ->add_option("--mixing", arguments->mixing,
                   "What mixes picture and building; auto: the processor where GL is software")
      ->check(CLI::IsMember({"auto", "gpu", "processor"}))
      ->capture_default_str();
  command
      ->add_option("--wipe", arguments->wipe,
                   "Left of this share of the width the camera's picture alone, as a visitor wipes it")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--view", arguments->view, "The building as a visitor may choose to see it")
      ->check(CLI::IsMember(std::vector<std::string>(kBuildingViewNames.begin(), kBuildingViewNames.end())))
      ->capture_default_str();
  command
      ->add_option("--scattering", arguments->scattering,
                   "Scattering coefficients; auto: the aerosol's where it is known, else morales2017")
      ->check(CLI::IsMember({"auto", "morales2017", "preetham", "zhao", "aerosol"}))
      ->capture_default_str();
  command->add_option("--zeta", arguments->zeta, "How airlight follows the direction: the full sky model or M Eq 13")
      ->check(CLI::IsMember({"full", "paper"}))
      ->capture_default_str();
  command->callback([arguments, &action] {
    action = [arguments]() -> Result<int> {
      // Each picture has threads of its own: more arenas slowly fill with what they leave.
      ::mallopt(M_ARENA_MAX, 2);
      const auto request = request_of(*arguments);
      const auto summary = replay(request);
      if (!summary) return fail(summary.error());
      print(*summary, request);
      if (summary->pictures > 0 || summary->interrupted) return 0;
      return fail(FaultKind::io, "{}: no picture was drawn: {}", request.fixture.string(), why_none(*summary));
    };
  });
}

}  // namespace kasumi
