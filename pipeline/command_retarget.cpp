#include <algorithm>
#include <cstdlib>
#include <memory>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "calib/adopt_calibration.hpp"
#include "calib/distance_map.hpp"
#include "capture/utc_text.hpp"
#include "estimator/sun.hpp"
#include "pipeline/command.hpp"
#include "pipeline/contact_sheet.hpp"
#include "pipeline/other_air.hpp"
#include "pipeline/picture_sink.hpp"
#include "pipeline/sky_photograph.hpp"

namespace kasumi {
namespace {

struct RetargetArguments {
  std::vector<std::string> pictures, turbidities;
  std::string camera, depth, sky, utc, target_picture, scattering = "morales2017", out, sheet, film;
  std::optional<double> depth_step_m, distance_m, source_turbidity, sun_zenith_deg, sun_azimuth_deg;
  double field_of_view_deg = 50.0, pitch_deg = 0.0, altitude_m = 0.0, frames_per_second = 10.0;
  double largest_gain = RetargetOptions{}.largest_gain;
  std::vector<double> airlight, target_airlight;
  bool keep_reflectance = false, same_exposure = false;
};

// "2.5", "clear", or "2:8:.25": from, to, step.
void read_turbidities(const RetargetArguments& arguments, std::vector<std::optional<Turbidity>>& targets,
                      Problems& problems) {
  const auto number = [](const std::string& text) -> std::optional<double> {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == '\0' ? std::optional(value) : std::nullopt;
  };
  const auto good = [](double t) { return t >= kLowestTurbidity.value && t <= kHighestTurbidity.value; };
  for (const auto& text : arguments.turbidities) {
    if (text == "clear") {
      targets.push_back(std::nullopt);
      continue;
    }
    const auto parts = CLI::detail::split(text, ':');
    std::vector<double> values;
    for (const auto& part : parts)
      if (const auto value = number(part)) values.push_back(*value);
    const bool one = parts.size() == 1 && values.size() == 1 && good(values[0]);
    const bool sweep = parts.size() == 3 && values.size() == 3 && good(values[0]) && good(values[1]) &&
                       values[2] > 0.0 && values[0] < values[1] && (values[1] - values[0]) / values[2] <= 10e3;
    if (one)
      targets.push_back(Turbidity{values[0]});
    else if (sweep)
      for (int i = 0; values[0] + i * values[2] <= values[1] + 1e-9; ++i)
        targets.push_back(Turbidity{std::min(values[0] + i * values[2], values[1])});
    else
      problems.add("--turbidity {}: expected a T of 1.7 to 20, FROM:TO:STEP, or clear", text);
  }
}

struct CameraFile {
  std::optional<Camera> scene, sky;
  std::optional<Site> site;
};
Result<CameraFile> read_camera_file(const std::string& file) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  CameraFile found;
  if (root->if_text("calibration")) adopt_calibration(*root);
  if (auto site = root->optional_table("site")) {
    found.site = read_site(*site);
    site->ignore("ground_albedo");
    site->ignore("cloud_base_m");
    site->ignore("fog");
  }
  found.scene = read_camera(root->table("scene"), "scene");
  if (auto sky = root->optional_table("sky")) found.sky = read_camera(*sky, "sky");
  for (const char* key :
       {"calibration", "format", "name", "description", "licence", "provenance", "start_utc", "object", "landmarks"})
    root->ignore(key);
  for (const char* key : {"point_spread_px", "shared_chroma", "noise", "depth_map", "depth_step_m"})
    if (auto scene = root->optional_table("scene")) scene->ignore(key);
  if (auto done = root->finish(); !done) return fail(done.error());
  return found;
}

// T of the pictures' own air: given, or seen in a picture of the sky.
Result<Turbidity> source_turbidity(const RetargetArguments& arguments, const CameraFile& camera,
                                   const std::optional<Utc>& utc, const std::optional<SunDirection>& sun) {
  if (arguments.source_turbidity) return Turbidity{*arguments.source_turbidity};
  SkyPhotographSetup setup;
  setup.calibrated = camera.sky;
  setup.site = camera.site;
  setup.utc = utc;
  if (!utc) setup.sun = sun;
  setup.sun_from_image = !utc && !sun;
  const auto report = SkyPhotographs(std::move(setup)).look_at(arguments.sky, utc);
  if (!report) return fail(report.error());
  const auto& estimate = report->look.estimate;
  if (!estimate.usable)
    return fail(FaultKind::bad_input,
                "{}: no turbidity to be had from this sky ({}): expected another picture, or --source-turbidity",
                arguments.sky, estimate.reason);
  fmt::print("source: T {:.2f} +- {:.2f} from {}\n", estimate.turbidity.value, estimate.sigma, arguments.sky);
  return estimate.turbidity;
}

std::optional<glm::dvec3> light_of(const std::vector<double>& values) {
  if (values.size() != 3) return std::nullopt;
  return glm::dvec3(values[0], values[1], values[2]);
}

struct Task {
  OtherAirSetup setup;
  std::vector<std::optional<Turbidity>> targets;
};

Result<Task> task_of(const RetargetArguments& a, const Photograph& first) {
  Task task;
  auto& setup = task.setup;
  Problems problems;
  read_turbidities(a, task.targets, problems);
  CameraFile file;
  if (!a.camera.empty()) {
    auto read = read_camera_file(a.camera);
    if (!read)
      problems.add("{}", read.error().message);
    else
      file = std::move(*read);
  }
  const int width = first.encoded.width(), height = first.encoded.height();
  setup.camera =
      file.scene.value_or(plain_camera(width, height, from_degrees(a.field_of_view_deg), from_degrees(a.pitch_deg)));
  setup.altitude_m = file.site ? file.site->altitude_m : a.altitude_m;

  std::optional<Utc> utc;
  if (!a.utc.empty()) {
    utc = parse_utc(a.utc);
    if (!utc) problems.add("--utc {}: expected a time like 2018-01-29T11:09:20Z", a.utc);
    if (!file.site) problems.add("--utc: expected a --camera file with [site], which places the sun");
  }
  if (a.sun_zenith_deg.has_value() != a.sun_azimuth_deg.has_value())
    problems.add("--sun-zenith-deg and --sun-azimuth-deg: expected both or neither");
  else if (a.sun_zenith_deg)
    setup.sun = direction_from(from_degrees(*a.sun_zenith_deg), from_degrees(*a.sun_azimuth_deg));
  else if (utc && file.site)
    setup.sun = sun_position(*utc, *file.site).direction;

  if (a.depth.empty() == !a.distance_m)
    problems.add("expected --depth FILE, or --distance-m where all that is not sky is about as far");
  else if (!a.depth.empty()) {
    auto distances = read_distances(a.depth, a.depth_step_m);
    if (!distances)
      problems.add("{}", distances.error().message);
    else if (distances->width() != width || distances->height() != height)
      problems.add("{}: is {} x {}: expected {} x {}, as the picture is", a.depth, distances->width(),
                   distances->height(), width, height);
    else
      setup.distance_m = std::move(*distances);
  }
  setup.everything_at_m = a.distance_m;
  if (a.source_turbidity.has_value() == !a.sky.empty())
    problems.add("expected --source-turbidity T, or --sky PICTURE to find it in");
  if (!a.target_airlight.empty() && !a.target_picture.empty())
    problems.add("--target-airlight and --target-picture: expected one of them, each tells the same");
  if (!problems.empty()) return fail(problems.fault());

  const auto source = source_turbidity(a, file, utc, setup.sun);
  if (!source) return fail(source.error());
  setup.source = *source;
  setup.airlight = light_of(a.airlight);
  setup.target_airlight = light_of(a.target_airlight);
  setup.scattering = scattering_model_named(a.scattering).value_or(ScatteringModel::morales2017);
  setup.relight = !a.keep_reflectance;
  setup.same_exposure = a.same_exposure;
  setup.largest_gain = a.largest_gain;
  if (!a.target_picture.empty()) {
    const auto picture = read_photograph(a.target_picture);
    if (!picture) return fail(picture.error());
    if (picture->encoded.width() != width || picture->encoded.height() != height)
      return fail(FaultKind::bad_input, "{}: is {} x {}: expected {} x {}, taken by the same camera", a.target_picture,
                  picture->encoded.width(), picture->encoded.height(), width, height);
    auto horizon = horizon_of(setup.camera, *picture, a.target_picture);
    if (!horizon) return fail(horizon.error());
    setup.target_horizon = std::move(*horizon);
  }
  return task;
}

std::string name_of(const std::optional<Turbidity>& target) {
  return target ? fmt::format("T{:.2f}", target->value) : "clear";
}

Result<> write_mask(const std::filesystem::path& path, const Image<std::uint8_t>& mask) {
  Image<Rgb8> picture(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.elements().size(); ++i) picture.elements()[i] = Rgb8(mask.elements()[i]);
  return write_png(path, picture);
}

// OUT itself for one picture under one air; else OUT/NAME.T2.50.png.
std::filesystem::path place_of(const RetargetArguments& arguments, const std::filesystem::path& picture,
                               const std::optional<Turbidity>& target, bool alone) {
  const std::filesystem::path out = arguments.out;
  return alone ? out : out / fmt::format("{}.{}.png", picture.stem().string(), name_of(target));
}

Result<int> retarget_pictures(const RetargetArguments& a) {
  // OpenCV reads depth as EXR only when told so.
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
  const auto first = read_photograph(a.pictures.front());
  if (!first) return fail(first.error());
  auto task = task_of(a, *first);
  if (!task) return fail(task.error());
  const bool alone = a.pictures.size() == 1 && task->targets.size() == 1;
  if (!alone && !a.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(a.out, error);
    if (error)
      return fail(FaultKind::bad_input, "--out {}: expected a folder, for several pictures ({})", a.out,
                  error.message());
  }
  OtherAir air(std::move(task->setup));
  ContactSheet sheet;
  std::unique_ptr<PictureSink> film;
  if (!a.film.empty()) {
    auto opened = open_film(a.film, a.frames_per_second);
    if (!opened) return fail(opened.error());
    film = std::move(*opened);
  }
  for (const auto& name : a.pictures) {
    auto photograph = read_photograph(name);
    if (!photograph) return fail(photograph.error());
    if (!a.sheet.empty()) sheet.add(to_rgb8(*photograph), "as taken");
    if (auto taken = air.take(std::move(*photograph), name); !taken) return fail(taken.error());
    for (const auto& target : task->targets) {
      const auto made = air.under(target);
      const auto pixels = to_rgb8(made.picture);
      if (!a.out.empty()) {
        const auto place = place_of(a, name, target, alone);
        auto mask = place;
        mask.replace_extension(".restored.png");
        if (auto done = write_photograph(place, made.picture); !done) return fail(done.error());
        if (auto done = write_mask(mask, made.restored); !done) return fail(done.error());
        fmt::print("{}: {}, {:.1f} % too faint to restore\n", place.string(), name_of(target),
                   100.0 * made.too_faint_fraction);
      }
      if (!a.sheet.empty()) sheet.add(pixels, name_of(target));
      if (film)
        if (auto done = film->put(pixels); !done) return fail(done.error());
    }
  }
  if (film)
    if (auto done = film->finish(); !done) return fail(done.error());
  if (!a.sheet.empty())
    if (auto done = sheet.write(a.sheet); !done) return fail(done.error());
  return 0;
}

}  // namespace

void add_retarget_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("retarget", "A photograph's scene under other air, clearer or thicker");
  auto arguments = std::make_shared<RetargetArguments>();
  auto& a = *arguments;
  command->add_option("picture", a.pictures, "Pictures of one camera")->required();
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
  command->add_option("--distance-m", a.distance_m, "In place of --depth: all that is not sky is about so far")
      ->check(CLI::Range(1.0, 200e3));
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
  command->add_flag("--same-exposure", a.same_exposure,
                    "Keep the exposure; else the horizon stays as bright, as an automatic exposure would have it");
  command
      ->add_option("--largest-gain", a.largest_gain,
                   "What would be amplified more than so keeps some haze, and is masked")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  command->add_option("--out", a.out, "Picture to write; a folder for several");
  command->add_option("--sheet", a.sheet, "All of them side by side, as one PNG");
  command->add_option("--film", a.film, "All of them as a film");
  command->add_option("--fps", a.frames_per_second, "Of the film")
      ->check(CLI::Range(0.1, 120.0))
      ->capture_default_str();
  command->callback([arguments, &action] {
    if (arguments->out.empty() && arguments->sheet.empty() && arguments->film.empty())
      throw CLI::ValidationError("--out, --sheet, --film", "expected at least one of them");
    action = [arguments] { return retarget_pictures(*arguments); };
  });
}

}  // namespace kasumi
