#include <cstdlib>
#include <memory>

#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/files/picture_source.hpp"
#include "pipeline/photographs/retarget_outputs.hpp"
#include "pipeline/photographs/retarget_task.hpp"

namespace kasumi {
namespace {

Result<int> retarget_pictures(const RetargetArguments& a) {
  // OpenCV reads EXR only when told so.
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
  const auto source = open_pictures(a.pictures);
  if (!source) return fail(source.error());
  auto picture = (*source)->next();
  if (!picture) return fail(picture.error());
  auto task = retarget_task(a, (*picture)->photograph);
  if (!task) return fail(task.error());
  // The camera stands still and the air with it: what one frame's horizon is off, the next ones' make good.
  if ((*source)->is_sequence()) task->setup.horizon_weight = 0.1;
  auto outputs = RetargetOutputs::open(a, task->targets, **source);
  if (!outputs) return fail(outputs.error());
  OtherAir air(std::move(task->setup));
  while (picture && *picture) {
    auto& [name, stem, photograph] = **picture;
    outputs->as_taken(photograph);
    if (auto taken = air.take(std::move(photograph), name); !taken) return fail(taken.error());
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
  auto* command = app.add_subcommand("retarget", "A photograph's scene under other air, clearer or thicker");
  auto arguments = std::make_shared<RetargetArguments>();
  auto& a = *arguments;
  command->add_option("picture", a.pictures, "Pictures of one camera; or one film, or a folder of its frames")
      ->required();
  command
      ->add_option("--turbidity", a.turbidities, "T to show it under: 2.5, FROM:TO:STEP, or clear; several with commas")
      ->required()
      ->delimiter(',');
  command->add_option("--source-turbidity", a.source_turbidity, "T of the air the pictures were taken in")
      ->check(CLI::Range(kLowestTurbidity.value, kHighestTurbidity.value));
  command->add_option("--sky", a.sky, "Estimate that T from this picture of the sky, taken by [sky] of --camera");
  command->add_option("--depth", a.depth, "Distances: PFM or EXR of metres, or a PNG of 16 bits; 0: sky");
  command->add_option("--depth-step-m", a.depth_step_m, "Metres that a step of the PNG is")
      ->check(CLI::Range(1e-4, 1e3));
  command->add_option("--planes", a.planes, "In place of --depth: TOML of ground and walls (docs/photographs.md)");
  command->add_option("--distance-m", a.distance_m, "In place of --depth: all that is not sky is about so far")
      ->check(CLI::Range(1.0, 200e3));
  command->add_flag("--from-haze", a.from_haze,
                    "In place of --depth: guess it, and the light from infinity, from the picture's own grey haze");
  command->add_option("--camera", a.camera, "TOML with [scene] (docs/cameras.md) and, if wanted, [sky], [site]");
  command->add_option("--fov-deg", a.field_of_view_deg, "Without --camera: across the picture")
      ->check(CLI::Range(0.5, 150.0))
      ->capture_default_str();
  command->add_option("--pitch-deg", a.pitch_deg, "Without --camera: elevation of the picture's middle")
      ->check(CLI::Range(-60.0, 60.0))
      ->capture_default_str();
  command->add_option("--altitude-m", a.altitude_m, "Without a [site]: of the camera")
      ->check(CLI::Range(-500.0, 9000.0))
      ->capture_default_str();
  command->add_option("--utc", a.utc, "When the pictures were taken, which places the sun");
  command->add_option("--sun-zenith-deg", a.sun_zenith_deg, "Zenith angle of the sun")->check(CLI::Range(0.0, 89.0));
  command
      ->add_option("--sun-azimuth-deg", a.sun_azimuth_deg,
                   "Azimuth of the sun, clockwise from north; without --camera from where the picture looks")
      ->check(CLI::Range(-360.0, 360.0));
  const auto light = [&](const char* name, std::vector<double>& values, const char* words) {
    command->add_option(name, values, words)
        ->type_name("R,G,B")
        ->delimiter(',')
        ->expected(3)
        ->check(CLI::Range(1e-3, 4.0));
  };
  light("--airlight", a.airlight, "Light from infinity, linear, of full scale; left out: measured at the horizon");
  light("--target-airlight", a.target_airlight, "The same under the other air; left out: by the sky model");
  command->add_option("--target-picture", a.target_picture, "Measure it at the horizon of this picture instead");
  command->add_option("--scattering", a.scattering, "Coefficients")
      ->check(CLI::IsMember({"morales2017", "preetham", "zhao"}))
      ->capture_default_str();
  command->add_flag("--keep-reflectance", a.keep_reflectance,
                    "As the paper: the light on the scene does not change with the air");
  command->add_flag("--amplify-noise", a.amplify_noise,
                    "Treat noise as light of the scene: what comes out of the haze is the grainier");
  command->add_flag("--same-exposure", a.same_exposure,
                    "Keep the exposure; else the horizon stays as bright, as an automatic exposure would have it");
  command
      ->add_option("--largest-gain", a.largest_gain,
                   "What would be amplified more than so keeps some haze, and is masked")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  command->add_option("--out", a.out, "Picture to write; a folder for several");
  command->add_option("--sheet", a.sheet, "All of them side by side, as one PNG");
  command->add_option("--film", a.film, "All of them as a film; of a film or folder one for each air");
  command->add_option("--fps", a.frames_per_second, "Of the film; left out: as the film that came, else 10")
      ->check(CLI::Range(0.1, 120.0));
  command->callback([arguments, &action] {
    if (arguments->out.empty() && arguments->sheet.empty() && arguments->film.empty())
      throw CLI::ValidationError("--out, --sheet, --film", "expected at least one of them");
    action = [arguments] { return retarget_pictures(*arguments); };
  });
}

}  // namespace kasumi
