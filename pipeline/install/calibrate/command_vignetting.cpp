#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/sky_camera/sky_vignetting.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/site/config/fixture_file.hpp"

namespace kasumi {

namespace {

constexpr Radians kLowestSunForVignetting = from_degrees(8.0);
constexpr Radians kNextSun = from_degrees(4.0);  // how far the sun moves from one picture to the next
constexpr std::size_t kMaxMoments = 40;

struct VignettingArguments {
  std::string fixture;
  std::optional<double> turbidity;
  double turbidity_sigma = 0.2;
  std::string serial;
  std::string out;
};

// The sky camera of the calibration file, which must have lens and orientation. Colour and mask come from the recording
// where the file lacks them.
Result<Camera> calibrated_camera(const std::string& file, const Camera* recorded) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    return fail(FaultKind::bad_input,
                "{}: expected the calibration file with the sky camera's lens and orientation (kasumi calibrate lens, "
                "kasumi calibrate sky)",
                file);
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  const auto sky = root->table("sky");
  auto camera = read_camera(sky, "sky");
  if (recorded && !sky.has("colour_space")) {
    camera.colour_space = recorded->colour_space;
    camera.white_balance = recorded->white_balance;
    camera.sensitivity = recorded->sensitivity;
  }
  if (recorded && !sky.has("yuv_encoding")) camera.yuv_encoding = recorded->yuv_encoding;
  if (recorded && camera.mask.empty()) camera.mask = recorded->mask;
  for (const auto& key : root->keys()) root->ignore(key);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return camera;
}

struct MomentsRead {
  std::vector<SunMoment> moments;
  int pictures = 0;  // that were considered
  PicturesRead read;
};

// Pictures with the sun in different places.
Result<MomentsRead> read_moments(const Fixture& fixture, const Camera& camera) {
  MomentsRead sky;
  const auto sun_at = [&](Utc utc) { return sun_position(utc, fixture.installation.site); };
  FrameSelection options;
  options.wanted = [&](const FrameMetadata& metadata) {
    if (sky.moments.size() >= kMaxMoments) return false;
    ++sky.pictures;
    const auto sun = sun_at(metadata.utc);
    if (sun.zenith > from_degrees(90.0) - kLowestSunForVignetting) return false;
    return sky.moments.empty() || angle_between(sun.direction, sky.moments.back().sun) >= kNextSun;
  };
  const auto read =
      for_each_picture(fixture, camera, options, [&](const PictureView& view, const FrameMetadata& metadata) {
        if (auto picture = sky_picture(view, camera))
          sky.moments.push_back({utc_text(metadata.utc), std::move(*picture), sun_at(metadata.utc).direction});
      });
  if (!read) return fail(read.error());
  sky.read = *read;
  return sky;
}

std::vector<std::string> remarks_of(const FoundVignetting& found) {
  return {fmt::format("a sky whose light differs from the model's by 3 % with the distance from the sun would change "
                      "the illumination at the rim by {:.1f} %",
                      100.0 * found.by_3_percent_about_sun),
          fmt::format("a sky 3 % brighter at the rim than in the model would be taken for {:+.1f} % of illumination "
                      "there: pictures from a level camera cannot separate that from the lens (a flat field can)",
                      100.0 * found.by_3_percent_at_rim)};
}

Result<int> calibrate(const VignettingArguments& arguments) {
  Problems problems;
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) problems.add("{}", fixture.error().message);
  const auto camera = calibrated_camera(arguments.out, fixture ? &fixture->installation.sky : nullptr);
  if (!camera) problems.add("{}", camera.error().message);
  if (fixture && camera &&
      (fixture->installation.sky.width != camera->width || fixture->installation.sky.height != camera->height))
    problems.add("{}: its pictures are {} x {}, expected {} x {} as in the sky camera's calibration", arguments.fixture,
                 fixture->installation.sky.width, fixture->installation.sky.height, camera->width, camera->height);
  if (!problems.empty()) return fail(problems.fault());

  const auto sky = read_moments(*fixture, *camera);
  if (!sky) return fail(sky.error());
  if (sky->moments.empty())
    return fail(FaultKind::bad_input,
                "{}: of {} pictures, {} are damaged and none has the sun {:.0f} deg above the horizon",
                arguments.fixture, sky->pictures, sky->read.damaged, to_degrees(kLowestSunForVignetting));
  VignettingRequest options;
  if (arguments.turbidity) options.turbidity = KnownTurbidity{*arguments.turbidity, arguments.turbidity_sigma};
  const auto found = vignetting_from_sky(*camera, sky->moments, options);
  if (!found) return fail(found.error().kind, "{}: {}", arguments.fixture, found.error().message);

  const auto& v = found->vignetting;
  const double rim = v.at(v.centre + glm::dvec2{v.radius_px, 0.0});
  const auto way = found->sun_way;
  for (std::size_t i = 0; i < sky->moments.size(); ++i)
    if (found->moments[i].used)
      fmt::print("  {}  T {:.2f}\n", sky->moments[i].name, found->moments[i].turbidity.value);
    else
      fmt::print("  {}  {}\n", sky->moments[i].name, found->moments[i].reason);
  fmt::print("vignetting [{:.4f}, {:.4f}, {:.4f}] over {:.1f} px: {:.3f} +- {:.3f} at the rim; residual {:.1f} %\n",
             v.coefficients[0], v.coefficients[1], v.coefficients[2], v.radius_px, rim, rim * found->rim_sigma,
             100.0 * found->residual);
  auto remarks = remarks_of(*found);
  for (const auto& remark : remarks) fmt::print("{}\n", remark);

  CalibrationStep step;
  step.camera = "sky";
  step.width = camera->width;
  step.height = camera->height;
  step.serial = arguments.serial;
  step.vignetting = v;
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  step.calibrated_utc = now;
  Measured measured{
      "vignetting",
      now,
      fmt::format("the clear sky in {} of {} pictures of the recording {}, {} to {}, the sun's path {:.0f} "
                  "deg",
                  found->pictures, sky->moments.size(), fixture->info.name, utc_text(sky->read.first),
                  utc_text(sky->read.last), to_degrees(way)),
      {{"rim_sigma", rim * found->rim_sigma},
       {"by_3_percent_about_sun", found->by_3_percent_about_sun},
       {"by_3_percent_at_rim", found->by_3_percent_at_rim},
       {"residual", found->residual},
       {"sun_way_deg", to_degrees(way)}},
      std::move(remarks)};
  for (std::size_t i = 0; i < sky->moments.size(); ++i)
    if (!found->moments[i].used)
      measured.remarks.push_back(fmt::format("{}: left out: {}", sky->moments[i].name, found->moments[i].reason));
  step.measured.push_back(std::move(measured));
  const auto title = fmt::format("{}: {:.3f} +- {:.3f} at the rim, from {} pictures", fixture->info.name, rim,
                                 rim * found->rim_sigma, found->pictures);
  return save_calibration(arguments.out, std::move(step), plot_vignetting(*found, title));
}

}  // namespace

void add_calibrate_vignetting(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "vignetting", "How the sky camera's picture darkens towards the rim, from hours of clear sky in a recording");
  auto arguments = std::make_shared<VignettingArguments>();
  auto& a = *arguments;
  command->add_option("fixture", a.fixture, "A recording of a mostly clear day, the sun high and low")->required();
  command
      ->add_option("--turbidity", a.turbidity,
                   "T of that day from another source, such as a sun photometer; without it, the sky must follow the "
                   "model closely")
      ->check(CLI::Range(kLowestTurbidity.value, kHighestTurbidity.value));
  command->add_option("--turbidity-sigma", a.turbidity_sigma, "Uncertainty of that T, one standard deviation")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str();
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command
      ->add_option(
          "--out", a.out,
          "The calibration file, which must have the sky camera's lens and orientation; it is kept as a backup")
      ->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi
