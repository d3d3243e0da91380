#include "pipeline/lab/sky/sky_options.hpp"

#include <cmath>
#include <cstdio>

#include "base/utc_text.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/sun.hpp"

namespace kasumi {
namespace {

constexpr double kStandardTurbidity = 2.5;

bool within(double value, double low, double high) {
  return value >= low && value <= high;  // false for NaN
}

void read_size(const SkyOptions& options, Viewpoint& camera, Problems& problems) {
  if (options.size.empty()) {
    if (camera.projection == PanoramaProjection::fisheye) camera.width = camera.height = 900;
    if (camera.projection == PanoramaProjection::equirectangular) camera.width = 2 * camera.height;
    return;
  }
  char rest = 0;
  if (std::sscanf(options.size.c_str(), "%dx%d%c", &camera.width, &camera.height, &rest) != 2 ||
      !within(camera.width, 16, 8192) || !within(camera.height, 16, 8192))
    problems.add("--size {}: expected WIDTHxHEIGHT, each 16 to 8192 pixels, like 1280x720", options.size);
}

void read_camera(const SkyOptions& options, Viewpoint& camera, Problems& problems) {
  if (const auto projection = panorama_projection_named(options.projection))
    camera.projection = *projection;
  else
    problems.add("--projection {}: expected fisheye, perspective or equirectangular", options.projection);
  read_size(options, camera, problems);
  if (!within(options.field_of_view_deg, 0.5, 150.0))
    problems.add("--fov-deg {:g}: expected 0.5 to 150", options.field_of_view_deg);
  if (!within(options.pitch_deg, -90.0, 90.0)) problems.add("--pitch-deg {:g}: expected -90 to 90", options.pitch_deg);
  if (!within(options.heading_deg, -360.0, 360.0))
    problems.add("--heading-deg {:g}: expected -360 to 360", options.heading_deg);
  camera.field_of_view_deg = options.field_of_view_deg;
  camera.heading_deg = options.heading_deg;
  camera.pitch_deg = options.pitch_deg;
}

void read_sun(const SkyOptions& options, DrawingTask& task, Problems& problems) {
  if (!options.site.empty()) {
    if (options.site.size() == 2 && within(options.site[0], -90.0, 90.0) && within(options.site[1], -180.0, 180.0)) {
      Site site;
      site.latitude_deg = options.site[0];
      site.longitude_deg = options.site[1];
      site.altitude_m = task.altitudes_m.front();
      task.site = site;
    } else {
      problems.add("--site: expected LATITUDE,LONGITUDE in degrees, like 34.69,135.80");
    }
  }
  if (!options.utc.empty()) {
    task.utc = parse_utc(options.utc);
    if (!task.utc) problems.add("--utc {}: expected a time like 2026-06-21T03:00:00Z", options.utc);
  }
  if (options.site.empty() != options.utc.empty())
    problems.add("--site and --utc: expected both, which place the sun, or neither");
  const bool given = options.sun_zenith_deg || options.sun_azimuth_deg;
  if (given && !options.utc.empty())
    problems.add("--sun-zenith-deg, --sun-azimuth-deg: not allowed with --utc, which places the sun");
  const double zenith = options.sun_zenith_deg.value_or(45.0), azimuth = options.sun_azimuth_deg.value_or(180.0);
  if (!within(zenith, 0.0, 92.0)) problems.add("--sun-zenith-deg {:g}: expected 0 to 92", zenith);
  if (!within(azimuth, -360.0, 360.0)) problems.add("--sun-azimuth-deg {:g}: expected -360 to 360", azimuth);
  task.sky.sun = direction_from(from_degrees(zenith), from_degrees(azimuth));
  if (task.site && task.utc) {
    const auto position = sun_position(*task.utc, *task.site);
    task.sky.sun = position.direction;
    if (options.day.empty() && position.zenith > kLowestDomeSun)
      problems.add("--utc {}: the sun is {:.1f} deg below the horizon at --site; expected 2 deg at most", options.utc,
                   to_degrees(position.zenith) - 90.0);
  }
}

void check_outputs(const SkyOptions& options, const DrawingTask& task, Problems& problems) {
  if (options.out.empty() && options.sheet.empty() && options.day.empty() && options.compare.empty() && !options.window)
    problems.add("expected --out, --sheet, --day, --compare or --window");
  if (options.sheet.empty() && task.turbidities.size() * task.altitudes_m.size() > 1)
    problems.add("several turbidities or altitudes: expected --sheet to lay them side by side");
  if (task.turbidities.size() * task.altitudes_m.size() > 100)
    problems.add("{} turbidities by {} altitudes: expected a sheet of 100 pictures at most", task.turbidities.size(),
                 task.altitudes_m.size());
  if (!options.day.empty() && (options.utc.empty() || options.site.empty()))
    problems.add("--day: expected --site and --utc, which say where and which day");
  if (!within(options.frames, 2, 10000)) problems.add("--frames {}: expected 2 to 10000", options.frames);
  if (!within(options.frames_per_second, 0.1, 120.0))
    problems.add("--fps {:g}: expected 0.1 to 120", options.frames_per_second);
  if (!options.out.empty()) {
    const auto extension = std::filesystem::path(options.out).extension();
    if (extension != ".png" && extension != ".exr" && extension != ".pfm" && extension != ".hdr")
      problems.add("--out {}: expected a name that ends in .png, .exr, .pfm or .hdr", options.out);
  }
}

}  // namespace

Result<DrawingTask> sky_task(const SkyOptions& options) {
  DrawingTask task;
  Problems problems;
  const GivenAir given = options.aerosol.given();
  if (!options.turbidities.empty() && !options.aods.empty())
    problems.add("--turbidity and --aod: expected only one of them");
  task.turbidities = options.turbidities;
  if (options.turbidities.empty() && options.aods.empty()) task.turbidities = {kStandardTurbidity};
  for (const double aod : options.aods) task.turbidities.push_back(turbidity_of(given.with(aod)));
  task.sky.like = options.aods.empty() ? given.to_be_found() : given.with(0.0);
  for (const double aod : options.aods)
    if (!within(aod, 0.0, kHighestDomeAod)) problems.add("--aod {:g}: expected 0 to {:g}", aod, kHighestDomeAod);
  task.altitudes_m = options.altitudes_m.empty() ? std::vector{0.0} : options.altitudes_m;
  for (const double t : options.turbidities)
    if (!within(t, kLowestTurbidity.value, kHighestDomeTurbidity.value))
      problems.add("--turbidity {:g}: expected {:g} to {:g}", t, kLowestTurbidity.value, kHighestDomeTurbidity.value);
  for (const double altitude : task.altitudes_m)
    if (!within(altitude, 0.0, kHighestDomeAltitude_m))
      problems.add("--altitude-m {:g}: expected 0 to {:g}", altitude, kHighestDomeAltitude_m);
  read_camera(options, task.camera, problems);
  read_sun(options, task, problems);
  if (const auto kind = sky_kind_named(options.model))
    task.sky.kind = *kind;
  else
    problems.add("--model {}: expected dome, preetham1999, hoffman-preetham2002 or nielsen2003", options.model);
  if (!within(options.exposure_ev, -20.0, 20.0))
    problems.add("--exposure-ev {:g}: expected -20 to 20", options.exposure_ev);
  if (options.terrain && task.camera.projection == PanoramaProjection::fisheye)
    problems.add("--terrain: a fisheye that looks up sees none; expected another --projection");
  if (options.terrain && task.sky.kind == SkyKind::preetham1999)
    problems.add("--terrain: preetham1999 is here for its sky alone; expected another --model");
  if (task.sky.like && task.sky.kind != SkyKind::dome)
    problems.add("--aod, --angstrom, --aerosol: only the dome knows an aerosol; expected --model dome");
  check_outputs(options, task, problems);
  if (!problems.empty()) return fail(problems.fault());
  task.sky.altitude_m = task.altitudes_m.front();
  task.sky.turbidity = {task.turbidities.front()};
  task.sky.exposure_ev = options.exposure_ev;
  task.sky.aerial_perspective = !options.no_aerial_perspective;
  task.mountains = options.terrain;
  return task;
}

}  // namespace kasumi
