#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/sky_camera/sky_sensitivity.hpp"
#include "pipeline/install/calibrate/calibrated_camera.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"

namespace kasumi {

namespace {

constexpr int kMaxSkyPictures = 24;
constexpr Radians kLowestSunForColour = from_degrees(8.0);  // below it Preetham's colours are unreliable

struct ColourArguments {
  std::string fixture;
  std::vector<std::string> cameras;
  std::optional<double> turbidity;
  bool choose = false;
  std::string camera = "sky";
  std::string serial;
  std::string out;
};

// Every named file, and every .json and .csv of every named folder.
std::vector<SpectralSensitivity> read_cameras(const std::vector<std::string>& names, Problems& problems) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path name : names) {
    std::error_code error;
    if (!std::filesystem::is_directory(name, error)) {
      files.push_back(name);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(name, error))
      if (entry.path().extension() == ".json" || entry.path().extension() == ".csv") inside.push_back(entry.path());
    std::sort(inside.begin(), inside.end());
    if (inside.empty()) problems.add("--cameras {}: no .json or .csv in it", name.string());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  std::vector<SpectralSensitivity> cameras;
  for (const auto& file : files) {
    auto camera = read_spectral_sensitivity(file);
    if (!camera)
      problems.add("{}", camera.error().message);
    else if (!separates_daylight(*camera))
      problems.add("{}: expected three different channels, which can separate the colours of the sky", file.string());
    else
      cameras.push_back(std::move(*camera));
  }
  return cameras;
}

struct ClearSkies {
  std::vector<SunMoment> moments;
  PicturesRead read;
  int low_sun = 0;
};

Result<ClearSkies> read_skies(const Fixture& fixture, const Camera& camera) {
  ClearSkies skies;
  const auto take_picture = [&](const PictureView& view, const FrameMetadata& metadata) {
    const auto sun = sun_position(metadata.utc, fixture.installation.site);
    if (sun.zenith > from_degrees(90.0) - kLowestSunForColour) {
      ++skies.low_sun;
      return;
    }
    if (auto picture = sky_picture(view, camera))
      skies.moments.push_back({utc_text(metadata.utc), std::move(*picture), sun.direction});
  };
  const auto read = for_each_picture(fixture, camera, {.most = kMaxSkyPictures}, take_picture);
  if (!read) return fail(read.error());
  skies.read = *read;
  return skies;
}

double root_mean_square(const std::vector<GammaError>& errors) {
  double sum = 0.0;
  for (const auto& error : errors) sum += error.largest * error.largest;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, errors.size())));
}

double worst(const std::vector<GammaError>& errors) {
  double most = 0.0;
  for (const auto& error : errors) most = std::max(most, error.largest);
  return most;
}

constexpr std::array kChannels{"red", "green", "blue"};

void report(const ClearSkies& skies, const std::vector<SpectralSensitivity>& cameras, const FoundSensitivity& found) {
  fmt::print("{} pictures: {} of a clear sky, {} of other skies, sun too low in {}; {} damaged\n", skies.read.good,
             found.turbidities.size(), found.refused.size(), skies.low_sun, skies.read.damaged);
  fmt::print("{} patches of sky, T {:.2f} to {:.2f}\n", found.colours,
             *std::min_element(found.turbidities.begin(), found.turbidities.end()),
             *std::max_element(found.turbidities.begin(), found.turbidities.end()));
  fmt::print("\nresiduals of each (log ratios to green, rms):\n");
  for (const auto& one : found.ranked) fmt::print("  {:<48} {:.4f}\n", cameras[one.camera].name, one.residuals.rms);
  if (found.fit) {
    fmt::print("  {:<48} {:.4f}\n\n", found.fit->sensitivity.name, found.fit->residuals.rms);
    fmt::print(
        "of the 6 numbers that daylight can determine, {} are determined better by this sky than by the measured "
        "cameras "
        "(best to worst {:.0f} : 1); the rest comes from the cameras\n",
        found.fit->determined, found.fit->condition);
    for (std::size_t c = 0; c < 3; ++c)
      fmt::print("  {:<6} mean {:.1f} +- {:.1f} nm (the cameras alone: +- {:.1f})\n", kChannels[c],
                 found.fit->places[c].mean_nm, found.fit->places[c].sigma_nm, found.fit->places[c].before_sigma_nm);
  }
  const auto& gains = found.residuals.white_balance;
  fmt::print("chosen: {}\nwhite balance [{:.4f}, {:.4f}, {:.4f}]\n", found.sensitivity.name, gains.r, gains.g, gains.b);
  if (!found.expected.empty())
    fmt::print(
        "Gamma, T 2 to 8, up to 10 km: expect an error of {:.4f}, {:.4f} at worst (each measured camera found "
        "under this sky from the others)\n",
        root_mean_square(found.expected), worst(found.expected));
  if (found.of_more_colourful_sky)
    fmt::print("a sky {:.0f} % more colourful than the model's would not show here, and would cost {:.4f}\n",
               100.0 * kMoreColourful, *found.of_more_colourful_sky);
}

std::vector<std::string> remarks_of(const std::vector<SpectralSensitivity>& cameras, const FoundSensitivity& found,
                                    const ColourArguments& arguments) {
  std::vector<std::string> remarks;
  for (const auto& one : found.ranked)
    remarks.push_back(fmt::format("{} explains the colours to {:.4f}", cameras[one.camera].name, one.residuals.rms));
  if (found.fit && found.fit->determined < 4)
    remarks.push_back(
        "undetermined: most of it: this sky has too few colours; add pictures with a low sun and with haze");
  if (!arguments.turbidity) remarks.push_back("T was estimated from the same pictures");
  if (found.expected.empty())
    remarks.push_back("undetermined: the error in Gamma: expected at least 3 measured cameras (--cameras)");
  if (found.residuals.rms > 0.03)
    remarks.push_back(
        "the sky's colours are not the model's by more than 3 %: haze of another kind, a wrong T, a white balance that "
        "changed during the recording, or colours the camera has converted");
  for (const auto& remark : found.refused) remarks.push_back("left out: " + remark);
  return remarks;
}

CalibrationStep step_of(const ColourArguments& arguments, const Fixture& fixture, const ClearSkies& skies,
                        const FoundSensitivity& found, const std::vector<std::string>& remarks,
                        const std::string& csv) {
  CalibrationStep step;
  const auto& camera = arguments.camera == "sky" ? fixture.installation.sky : fixture.installation.scene;
  step.camera = arguments.camera;
  step.width = camera.width;
  step.height = camera.height;
  step.serial = arguments.serial;
  step.sensitivity = csv;
  // Another camera of the same make has the same filters, but perhaps another white balance.
  if (arguments.camera == "sky") step.white_balance = found.residuals.white_balance;
  step.site = fixture.installation.site;
  step.calibrated_utc = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  Measured measured{"colour",
                    step.calibrated_utc,
                    fmt::format("the colours of the clear sky in {} of {} pictures of the recording {}, {} to {}: {}",
                                found.turbidities.size(), skies.read.good, fixture.info.name,
                                utc_text(skies.read.first), utc_text(skies.read.last), found.sensitivity.name),
                    {{"rms_log_ratio", found.residuals.rms}},
                    remarks};
  if (found.fit && !arguments.choose) {
    measured.numbers.emplace_back("determined_of_6", found.fit->determined);
    measured.numbers.emplace_back("condition", found.fit->condition);
    measured.numbers.emplace_back("gain_red_sigma_percent", 100.0 * found.fit->gain_sigma.x);
    measured.numbers.emplace_back("gain_blue_sigma_percent", 100.0 * found.fit->gain_sigma.y);
    for (std::size_t c = 0; c < 3; ++c) {
      measured.numbers.emplace_back(fmt::format("{}_mean_nm", kChannels[c]), found.fit->places[c].mean_nm);
      measured.numbers.emplace_back(fmt::format("{}_mean_sigma_nm", kChannels[c]), found.fit->places[c].sigma_nm);
    }
  }
  if (!found.expected.empty()) {
    measured.numbers.emplace_back("gamma_error_expected", root_mean_square(found.expected));
    measured.numbers.emplace_back("gamma_error_worst", worst(found.expected));
  }
  if (found.of_more_colourful_sky)
    measured.numbers.emplace_back("gamma_error_of_sky_10_percent_off", *found.of_more_colourful_sky);
  step.measured.push_back(std::move(measured));
  return step;
}

Result<int> calibrate(const ColourArguments& arguments) {
  Problems problems;
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) problems.add("{}", fixture.error().message);
  const auto cameras = read_cameras(arguments.cameras, problems);
  auto camera = fixture ? calibrated_camera(*fixture, arguments.out, "sky") : Result<Camera>();
  if (!camera) problems.add("{}", camera.error().message);
  if (camera && fixture)
    for (const auto& [name, space] :
         {std::pair{std::string("sky"), camera->colour_space},
          {arguments.camera, arguments.camera == "sky" ? Camera::ColourSpace::sensor  // checked above
                                                       : fixture->installation.scene.colour_space}})
      if (space != Camera::ColourSpace::sensor)
        problems.add(
            "{}: {}.colour_space = \"srgb\": expected \"sensor\": a camera that has converted its colours shows "
            "its conversion in the sky, not its sensor",
            (fixture->folder / "fixture.toml").string(), name);
  if (!problems.empty()) return fail(problems.fault());

  const auto skies = read_skies(*fixture, *camera);
  if (!skies) return fail(skies.error());
  if (skies->moments.empty())
    return fail(FaultKind::bad_input, "{}: the sun is lower than {:.0f} deg in all pictures: expected some of day",
                arguments.fixture, to_degrees(kLowestSunForColour));
  const auto found = sensitivity_from_sky(*camera, skies->moments, cameras, {arguments.turbidity, arguments.choose});
  if (!found) return fail(found.error().kind, "{}: {}", arguments.fixture, found.error().message);
  report(*skies, cameras, *found);
  const auto remarks = remarks_of(cameras, *found, arguments);
  for (const auto& remark : remarks)
    if (remark.find("explains the colours") == std::string::npos) fmt::print("{}\n", remark);

  const auto csv = beside(arguments.out, arguments.camera + "-sensitivity.csv");
  const auto step = step_of(arguments, *fixture, *skies, *found, remarks, csv.filename().string());
  const auto kept = keep_old(csv);
  if (!kept) return fail(kept.error());
  const auto comment = fmt::format("kasumi calibrate colour, {}\n{}", step.calibrated_utc, step.measured.front().from);
  if (auto written = write_text_file(csv, csv_of(found->sensitivity, comment)); !written) return fail(written.error());
  fmt::print("written: {}\n", csv.string());
  if (*kept) fmt::print("the previous file was kept as {}\n", (*kept)->string());
  const auto title = fmt::format("{}: colours to {:.2f} %; Gamma +- {:.4f}", found->sensitivity.name,
                                 100.0 * found->residuals.rms, root_mean_square(found->expected));
  return save_calibration(arguments.out, step, plot_colour(found->sensitivity, cameras, found->residuals, title));
}

}  // namespace

void add_calibrate_colour(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "colour", "Spectral sensitivity and white balance of a camera, from the colours of clear skies");
  auto arguments = std::make_shared<ColourArguments>();
  auto& a = *arguments;
  command->add_option("fixture", a.fixture, "A recording of clear sky, the sun at several heights")->required();
  command->add_option("--cameras", a.cameras, "Measured cameras as a prior: rawtoaces .json, .csv, or folders of them")
      ->required();
  command->add_option("--turbidity", a.turbidity, "T of the recorded air, if known; default: estimated")
      ->check(CLI::Range(1.7, 20.0));
  command
      ->add_option("--camera", a.camera,
                   "Which camera to write it for; scene: a scene camera of the same make (without white balance)")
      ->check(CLI::IsMember({"sky", "scene"}))
      ->capture_default_str();
  command->add_flag("--choose", a.choose, "Take the measured camera that explains the sky best, instead of estimating");
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command
      ->add_option("--out", a.out,
                   "The calibration file; what it says of the camera is used, an older file is kept as a backup")
      ->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi
