#include <cstdlib>
#include <memory>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/lab/haze/retarget_outputs.hpp"
#include "pipeline/lab/haze/retarget_task.hpp"
#include "pipeline/lab/photographs/sky_model_choice.hpp"
#include "pipeline/site/files/picture_source.hpp"

namespace kasumi {
namespace {

Result<int> retarget_pictures(const RetargetRequest& a) {
  // OpenCV reads EXR only when this variable is set.
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
  const auto source = open_pictures(a.pictures, a.allow_damaged);
  if (!source) return fail(source.error());
  auto picture = (*source)->next();
  if (!picture) return fail(picture.error());
  auto task = retarget_task(a, (*picture)->photograph);
  if (!task) return fail(task.error());
  // The camera stands still and the air with it: errors of the horizon average out over the frames.
  if ((*source)->is_sequence()) task->setup.horizon_weight = 0.1;
  auto outputs = RetargetOutputs::open(a, task->target_names, **source);
  if (!outputs) return fail(outputs.error());
  OtherAir air(std::move(task->setup));
  while (picture && *picture) {
    auto& [name, stem, photograph, damage] = **picture;
    if (!damage.empty()) spdlog::warn("{}: {}; what is left of it is used", name, damage);
    outputs->as_taken(photograph);
    if (auto taken = air.set_picture(std::move(photograph), name); !taken) return fail(taken.error());
    for (std::size_t i = 0; i < task->targets.size(); ++i)
      if (auto done = outputs->put(stem, i, air.under(task->targets[i])); !done) return fail(done.error());
    picture = (*source)->next();
  }
  if (!picture) return fail(picture.error());
  if (auto done = outputs->finish(); !done) return fail(done.error());
  return 0;
}

}  // namespace

void add_retarget_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("retarget", "A photograph's scene under other air, clearer or hazier");
  auto arguments = std::make_shared<RetargetRequest>();
  auto& a = *arguments;
  command->add_option("picture", a.pictures, "Pictures of one camera; or one film, or a folder of its frames")
      ->required();
  command->add_option("--turbidity", a.turbidities, "Target T: 2.5, FROM:TO:STEP, or clear; several with commas")
      ->delimiter(',');
  command
      ->add_option("--aod", a.aods,
                   "Target aerosol optical depth at 550 nm, instead of T: 0.3, FROM:TO:STEP, or clear; several")
      ->delimiter(',');
  command->add_option("--source-turbidity", a.source_turbidity, "T of the air in the pictures")
      ->check(CLI::Range(kLowestTurbidity.value, kHighestTurbidity.value));
  command->add_option("--source-aod", a.source_aod, "Aerosol optical depth of the air in the pictures, instead of T")
      ->check(CLI::Range(0.0, kHighestGivenAod));
  add_aerosol_options(*command, a.aerosol);
  command->add_option("--sky", a.sky, "Estimate the source T from this picture of the sky, taken by [sky] of --camera");
  command->add_option("--sky-model", a.sky_model, std::string(kSkyModelWords) + ". Default: auto; for --sky")
      ->type_name("MODEL");
  add_distance_options(*command, a.distances, "sky");
  command->add_option("--planes", a.planes, "Instead of --depth: TOML of ground and walls (docs/photographs.md)");
  command->add_option("--distance-m", a.distance_m, "Instead of --depth: one distance for everything but the sky")
      ->check(CLI::Range(1.0, 200e3));
  command->add_flag("--from-haze", a.from_haze,
                    "Instead of --depth: estimate it, and the light from infinity, from the picture's own grey haze");
  command->add_option("--camera", a.camera, "TOML with [scene] (docs/cameras.md) and, if wanted, [sky], [site]");
  command->add_option("--fov-deg", a.field_of_view_deg, "Without --camera: horizontal field of view")
      ->check(CLI::Range(0.5, 150.0))
      ->capture_default_str();
  command->add_option("--pitch-deg", a.pitch_deg, "Without --camera: elevation of the picture's centre")
      ->check(CLI::Range(-60.0, 60.0))
      ->capture_default_str();
  command->add_option("--altitude-m", a.altitude_m, "Without [site]: altitude of the camera")
      ->check(CLI::Range(-500.0, 9000.0))
      ->capture_default_str();
  command->add_option("--utc", a.utc, "Time of the pictures, which determines the sun's position");
  command->add_option("--sun-zenith-deg", a.sun_zenith_deg, "Zenith angle of the sun")->check(CLI::Range(0.0, 89.0));
  command
      ->add_option("--sun-azimuth-deg", a.sun_azimuth_deg,
                   "Azimuth of the sun, clockwise from north; without --camera from the picture's own azimuth")
      ->check(CLI::Range(-360.0, 360.0));
  const auto light = [&](const char* name, std::vector<double>& values, const char* words) {
    command->add_option(name, values, words)
        ->type_name("R,G,B")
        ->delimiter(',')
        ->expected(3)
        ->check(CLI::Range(1e-3, 4.0));
  };
  light("--airlight", a.airlight, "Light from infinity, linear, full scale 1; default: measured at the horizon");
  light("--target-airlight", a.target_airlight, "The same under the target air; default: from the sky model");
  command->add_option("--target-picture", a.target_picture,
                      "Measure the target airlight at the horizon of this picture instead");
  command
      ->add_option("--scattering", a.scattering,
                   "Scattering coefficients; auto: the aerosol's where it is known, else morales2017")
      ->check(CLI::IsMember({"auto", "morales2017", "preetham", "zhao", "aerosol"}))
      ->capture_default_str();
  command->add_flag("--keep-reflectance", a.keep_reflectance, "As in the paper: keep the light on the scene unchanged");
  command->add_flag("--amplify-noise", a.amplify_noise,
                    "Amplify noise with the signal: what is restored gets grainier");
  command->add_flag("--same-exposure", a.same_exposure,
                    "Keep the exposure; default: keep the horizon's brightness, as automatic exposure does");
  command
      ->add_option("--largest-gain", a.largest_gain,
                   "Pixels that would need a larger gain keep some haze and are masked")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  command->add_flag(
      "--terms", a.terms,
      "Next to each picture its airlight and its direct transmission, which add up to it in linear light");
  command->add_flag("--allow-damaged", a.allow_damaged,
                    "Use what is left of damaged pictures, and say so; default: refuse them");
  command->add_option("--out", a.out, "Picture to write; a folder for several");
  command->add_option("--sheet", a.sheet, "All pictures side by side, as one PNG");
  command->add_option("--film", a.film, "All pictures as a film; from a film or folder, one film per target");
  command->add_option("--fps", a.frames_per_second, "Frame rate of the film; default: that of the input, else 10")
      ->check(CLI::Range(0.1, 120.0));
  command->callback([arguments, &action] {
    if (arguments->out.empty() && arguments->sheet.empty() && arguments->film.empty())
      throw CLI::ValidationError("--out, --sheet, --film", "expected at least one of them");
    action = [arguments] { return retarget_pictures(*arguments); };
  });
}

}  // namespace kasumi
