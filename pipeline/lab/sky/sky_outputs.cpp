// The pictures, sheets and films that `kasumi sky` writes.
#include <cmath>

#include "estimator/sky/dome.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/lab/sky/sky_comparison.hpp"
#include "pipeline/lab/sky/sky_options.hpp"
#include "pipeline/lab/sky/sky_window.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/light_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

Result<Image<Rgb8>> draw_one(DomeDrawing& drawing, const Viewpoint& camera, const DomeRequest& asked, bool mountains) {
  const DomeRequest sky = standing_on_land(camera, asked);
  const auto land = land_for(camera, sky.altitude_m, mountains);
  const LandAround* around = land ? &*land : nullptr;
  return drawing.draw(view_of(camera), scene_seen(camera, sky, around), around);
}

Result<> write_out(const SkyOptions& options, const DrawingTask& task, DomeDrawing& drawing) {
  if (is_light_file(options.out)) {
    const DomeRequest sky = standing_on_land(task.camera, task.sky);
    const auto land = land_for(task.camera, sky.altitude_m, task.mountains);
    std::optional<LandRayCaster> sight;
    if (land) sight.emplace(land->land, land->from, land->to);
    return write_light_file(options.out,
                            sky_light_picture(view_of(task.camera), sky_scene(sky), sight ? &*sight : nullptr));
  }
  const auto picture = draw_one(drawing, task.camera, task.sky, task.mountains);
  if (!picture) return fail(picture.error());
  return write_png(options.out, *picture);
}

Result<> write_sheet(const SkyOptions& options, const DrawingTask& task, DomeDrawing& drawing) {
  ContactSheet sheet;
  // One exposure for all, so that the sheet shows which is brighter.
  DomeRequest first = task.sky;
  first.exposure_ev = 0.0;
  first = standing_on_land(task.camera, first);
  const auto first_land = land_for(task.camera, first.altitude_m, task.mountains);
  const double exposure = scene_seen(task.camera, first, first_land ? &*first_land : nullptr).exposure;
  for (const double altitude_m : task.altitudes_m)
    for (const double t : task.turbidities) {
      DomeRequest sky = task.sky;
      sky.altitude_m = altitude_m;
      sky.turbidity = {t};
      sky.exposure = exposure;
      const auto picture = draw_one(drawing, task.camera, sky, task.mountains);
      if (!picture) return fail(picture.error());
      const auto air = sky.like ? fmt::format("AOD {:.3g}", sky.aerosol().aod_550) : fmt::format("T {:g}", t);
      sheet.add(*picture, fmt::format("{}, {:g} km", air, altitude_m / 1000.0));
    }
  // Turbidities side by side, altitudes one below the other; a single row where there is one turbidity.
  const std::size_t columns = task.turbidities.size() > 1 ? task.turbidities.size() : task.altitudes_m.size();
  return write_png(options.sheet, sheet.drawn(static_cast<int>(columns)));
}

// The moments of the day around `utc` at which the sun stands high enough for a sky.
std::vector<SunDirection> suns_of_day(const DrawingTask& task, int frames) {
  constexpr int kMinutes = 24 * 60;
  // Centred on local noon.
  const auto day = std::chrono::floor<std::chrono::days>(
      *task.utc + std::chrono::minutes(std::lround(4.0 * task.site->longitude_deg)));
  const Utc start = day - std::chrono::minutes(std::lround(4.0 * task.site->longitude_deg));
  std::vector<SunDirection> light;
  for (int minute = 0; minute < kMinutes; ++minute) {
    const auto sun = sun_position(start + std::chrono::minutes(minute), *task.site);
    if (sun.zenith <= kLowestDomeSun) light.push_back(sun.direction);
  }
  std::vector<SunDirection> suns;
  for (int i = 0; i < frames && !light.empty(); ++i)
    suns.push_back(light[light.size() * static_cast<std::size_t>(i) / static_cast<std::size_t>(frames)]);
  return suns;
}

Result<> write_day(const SkyOptions& options, const DrawingTask& task, DomeDrawing& drawing) {
  const auto suns = suns_of_day(task, options.frames);
  if (suns.empty())
    return fail(FaultKind::bad_input, "--day: the sun does not rise at --site on that day; expected another day");
  auto sink = std::filesystem::path(options.day).has_extension() ? open_film(options.day, options.frames_per_second)
                                                                 : open_picture_folder(options.day);
  if (!sink) return fail(sink.error());
  DomeRequest sky = standing_on_land(task.camera, task.sky);
  const auto land = land_for(task.camera, sky.altitude_m, task.mountains);
  for (const SunDirection& sun : suns) {
    sky.sun = sun;
    const LandAround* around = land ? &*land : nullptr;
    const auto picture = drawing.draw(view_of(task.camera), scene_seen(task.camera, sky, around), around);
    if (!picture) return fail(picture.error());
    if (auto put = (*sink)->put(*picture); !put) return put;
  }
  return (*sink)->finish();
}

Result<> write_comparison(const SkyOptions& options, const DrawingTask& task, DomeDrawing& drawing) {
  const auto low = direction_from(from_degrees(88.0), azimuth_angle(task.sky.sun));
  ContactSheet sheet;
  fmt::print("{:<22} {:>22} {:>30}\n", "", "darkest / opposite sun", "zenith under a sun of 2 deg");
  using enum SkyKind;
  for (const SkyKind kind : {dome, preetham1999, hoffman_preetham2002, nielsen2003}) {
    DomeRequest sky = task.sky;
    sky.kind = kind;
    const auto picture = draw_one(drawing, task.camera, sky, false);
    if (!picture) return fail(picture.error());
    sheet.add(*picture, std::string(name_of(kind)));
    const auto flaws = flaws_of(kind, sky.turbidity, sky.sun, low);
    fmt::print("{:<22} {:>22.3f} {:>13.0f} cd/m2, x {:.4f} y {:.4f}\n", name_of(kind), flaws.band,
               flaws.zenith_luminance, flaws.zenith_x, flaws.zenith_y);
  }
  return write_png(options.compare, sheet.drawn(2));
}

}  // namespace

Result<int> run_sky(const SkyOptions& options) {
  const auto task = sky_task(options);
  if (!task) return fail(task.error());
  // Only the CPU reference writes floating-point light.
  const bool a_picture = !options.out.empty() && !is_light_file(options.out);
  const bool by_gpu =
      !options.cpu && (a_picture || !options.sheet.empty() || !options.day.empty() || !options.compare.empty());
  auto drawing = by_gpu ? DomeDrawing::by_gpu() : Result<DomeDrawing>(DomeDrawing::by_cpu());
  if (!drawing) return fail(drawing.error().kind, "{}; --cpu needs none", drawing.error().message);
  const auto step = [&](const std::string& wanted, auto work) -> Result<> {
    return wanted.empty() ? Result<>{} : work(options, *task, *drawing);
  };
  for (const auto& done : {step(options.out, write_out), step(options.sheet, write_sheet), step(options.day, write_day),
                           step(options.compare, write_comparison)})
    if (!done) return fail(done.error());
  if (options.window)
    if (auto shown = show_sky_window(*task); !shown) return fail(shown.error());
  return 0;
}

}  // namespace kasumi
