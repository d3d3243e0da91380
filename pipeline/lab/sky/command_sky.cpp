#include <memory>

#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/lab/sky/sky_options.hpp"

namespace kasumi {

void add_sky_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("sky", "The clear sky and the air in between, from any altitude");
  auto options = std::make_shared<SkyOptions>();
  auto& o = *options;
  // The options depend on each other, so sky_options.cpp checks them together.
  command->add_option("--projection", o.projection, "fisheye, perspective or equirectangular")->capture_default_str();
  command->add_option("--size", o.size, "Size of the picture, like 1280x720; square for a fisheye");
  command->add_option("--fov-deg", o.field_of_view_deg, "Perspective: horizontal field of view")->capture_default_str();
  command->add_option("--heading-deg", o.heading_deg,
                      "Azimuth of the centre, clockwise from north; fisheye: of the top");
  command->add_option("--pitch-deg", o.pitch_deg, "Perspective: elevation of the centre")->capture_default_str();
  command->add_option("--turbidity", o.turbidities, "T, 1.7 to 10; several with commas for --sheet")->delimiter(',');
  command
      ->add_option("--aod", o.aods,
                   "Instead of T: aerosol optical depth at 550 nm, 0 to 1.8; several with commas for --sheet")
      ->delimiter(',');
  add_aerosol_options(*command, o.aerosol);
  command
      ->add_option("--altitude-m", o.altitudes_m,
                   "Altitude of the observer, 0 to 30000; several with commas for --sheet")
      ->delimiter(',');
  command->add_option("--sun-zenith-deg", o.sun_zenith_deg, "Zenith angle of the sun, 0 to 92");
  command->add_option("--sun-azimuth-deg", o.sun_azimuth_deg, "Azimuth of the sun, clockwise from north");
  command->add_option("--site", o.site, "LATITUDE,LONGITUDE in degrees; with --utc determines the sun's position")
      ->delimiter(',');
  command->add_option("--utc", o.utc, "Time, like 2026-06-21T03:00:00Z");
  command->add_option("--model", o.model, "dome; for comparison: preetham1999, hoffman-preetham2002, nielsen2003")
      ->capture_default_str();
  command->add_option("--exposure-ev", o.exposure_ev, "Exposure compensation, in stops");
  command->add_flag("--terrain", o.terrain, "A synthetic landscape with mountains instead of the bare plain");
  command->add_flag("--no-aerial-perspective", o.no_aerial_perspective, "Land without the air in front of it");
  command->add_flag("--cpu", o.cpu, "Render with the slow CPU reference instead of the GPU");
  command->add_option("--out", o.out, "Picture: PNG, or luminance in cd/m2, linear sRGB: EXR, PFM, HDR");
  command->add_option("--sheet", o.sheet, "All turbidities by all altitudes at one exposure, as one PNG");
  command->add_option("--day", o.day, "The day of --utc at --site from dawn to dusk: a film, or a folder of PNGs");
  command->add_option("--frames", o.frames, "Number of frames of the day")->capture_default_str();
  command->add_option("--fps", o.frames_per_second, "Frame rate of the film")->capture_default_str();
  command->add_option("--compare", o.compare,
                      "This sky next to earlier sky models, as one PNG, with their flaws in numbers");
  command->add_flag("--window", o.window, "Look around: drag the sun; keys for turbidity and altitude");
  command->callback([options, &action] { action = [options] { return run_sky(*options); }; });
}

}  // namespace kasumi
