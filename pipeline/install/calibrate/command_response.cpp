#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "calib/light/exposure_stack.hpp"
#include "calib/light/one_view.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/site/files/light_file.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

namespace {

struct ResponseArguments {
  std::vector<std::string> pictures, darks, flats;
  std::vector<double> exposures_s;
  double exposure_percent = 0.0;
  std::vector<double> circle;
  std::string camera = "sky";
  std::string serial;
  std::string merged;
  std::string out;
};

struct MeasuredResponse {
  ResponseCalibration calibration;
  MeasuredCurve curve;
  std::optional<NoiseModel> noise;
  DarkFrame dark;
  std::optional<VignettingFit> vignetting;
  std::vector<std::string> remarks;
};

// The straight line needs no table.
MeasuredCurve curve_of(const ResponseCalibration& calibration, const glm::dvec3& black) {
  MeasuredCurve curve;
  if (calibration.fit.is_straight && black == glm::dvec3(0.0)) return curve;
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    curve.light[i] = over_black(calibration.fit.light[i], black[c]);
  }
  return curve;
}

void report(const KnownStack& known, const MeasuredResponse& found) {
  for (const auto& candidate : found.calibration.candidates)
    if (candidate.held_out_steps)
      fmt::print("{:<36} predicts unseen pixels to {:.3f} steps\n", candidate.method, *candidate.held_out_steps);
    else
      fmt::print("{:<36} does not fit\n", candidate.method);
  fmt::print("\nchosen: {}\n", found.calibration.fit.method);
  const auto& log_s = found.calibration.fit.log_s;
  std::vector<std::size_t> order(log_s.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return log_s[a] < log_s[b]; });
  for (std::size_t k = 0; k < order.size(); ++k)
    fmt::print("  {:<60} {}\n", known.stack.names[order[k]],
               k == 0 ? std::string("ratio") : fmt::format("{:.3f}", std::exp(log_s[order[k]] - log_s[order[k - 1]])));
  if (found.noise)
    fmt::print("noise: full scale is {:.0f} electrons, read noise {:.1f} electrons\n",
               found.noise->full_scale_electrons(), found.noise->read_electrons());
  fmt::print("black level {:.4f}, {:.4f}, {:.4f} of full scale; {} hot pixels\n", found.dark.black.x,
             found.dark.black.y, found.dark.black.z, found.dark.hot.size());
  if (found.vignetting) {
    const auto& v = found.vignetting->vignetting;
    fmt::print("vignetting [{:.4f}, {:.4f}, {:.4f}] over {:.1f} px: {:.3f} +- {:.4f} at the rim, residual {:.2f} %\n",
               v.coefficients[0], v.coefficients[1], v.coefficients[2], v.radius_px,
               v.at(v.centre + glm::dvec2{v.radius_px, 0.0}), found.vignetting->rim_sigma,
               100.0 * found.vignetting->residual);
  }
  for (const auto& remark : found.remarks) fmt::print("{}\n", remark);
}

std::vector<Measured> measured_of(const ResponseArguments& arguments, const KnownStack& known,
                                  const MeasuredResponse& found, const std::string& now) {
  Measured measured{"response",
                    now,
                    fmt::format("{} exposures of one view, by {}: {}", known.stack.names.size(),
                                found.calibration.fit.method, fmt::join(known.stack.names, ", ")),
                    {{"held_out_steps", found.calibration.held_out_steps}},
                    found.remarks};
  for (std::size_t k = 1; k < found.calibration.fit.log_s.size(); ++k)
    measured.numbers.emplace_back(fmt::format("ratio_{}", k),
                                  std::exp(found.calibration.fit.log_s[k] - found.calibration.fit.log_s[k - 1]));
  if (found.noise) {
    measured.numbers.emplace_back("full_scale_electrons", found.noise->full_scale_electrons());
    measured.numbers.emplace_back("read_electrons", found.noise->read_electrons());
  }
  if (!arguments.darks.empty()) {
    for (const auto& [key, value] :
         {std::pair{"black_red", found.dark.black.x}, std::pair{"black_green", found.dark.black.y},
          std::pair{"black_blue", found.dark.black.z}})
      measured.numbers.emplace_back(key, value);
    measured.numbers.emplace_back("hot_pixels", static_cast<double>(found.dark.hot.size()));
  }
  std::vector<Measured> all{measured};
  if (found.vignetting)
    all.push_back({"vignetting",
                   now,
                   fmt::format("{} pictures of an evenly lit surface", arguments.flats.size()),
                   {{"rim_sigma", found.vignetting->rim_sigma}, {"residual", found.vignetting->residual}},
                   {}});
  return all;
}

void remark(MeasuredResponse& found, const ResponseArguments& arguments, const KnownStack& known) {
  auto& remarks = found.remarks;
  for (const auto& name : known.left_out)
    remarks.push_back(name + ": left out, too dark or too bright to overlap with the others");
  for (const auto& remark : found.calibration.undetermined) remarks.push_back("undetermined: " + remark);
  if (arguments.darks.empty())
    remarks.push_back("undetermined: black level and hot pixels: no picture with the lens covered was given (--dark)");
  if (arguments.flats.empty())
    remarks.push_back("undetermined: vignetting: no picture of an evenly lit surface was given (--flat)");
  if (!found.noise) remarks.push_back("undetermined: noise: none above quantisation was found");
  constexpr std::size_t kMaxListed = 50;
  for (std::size_t i = 0; i < std::min(kMaxListed, found.dark.hot.size()); ++i)
    remarks.push_back(fmt::format("hot pixel at ({}, {})", found.dark.hot[i].x, found.dark.hot[i].y));
  if (found.dark.hot.size() > kMaxListed)
    remarks.push_back(fmt::format("and {} more hot pixels", found.dark.hot.size() - kMaxListed));
}

Result<> check(const ResponseArguments& arguments) {
  Problems problems;
  if (arguments.pictures.size() < 2)
    problems.add("{} pictures: expected at least 2 of one view, 5 or more are better", arguments.pictures.size());
  if (!arguments.exposures_s.empty() && arguments.exposures_s.size() != arguments.pictures.size())
    problems.add("--exposures-s: {} times, expected {}, one for each picture", arguments.exposures_s.size(),
                 arguments.pictures.size());
  for (const double seconds : arguments.exposures_s)
    if (!(seconds > 0.0)) problems.add("--exposures-s {}: expected a time > 0", seconds);
  if (arguments.exposures_s.empty() && arguments.exposure_percent > 0.0)
    problems.add("--exposure-percent {}: expected together with --exposures-s", arguments.exposure_percent);
  if (!arguments.circle.empty() && !(arguments.circle[2] > 0.0))
    problems.add("--circle: radius {} px, expected more than 0", arguments.circle[2]);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

// All pictures must have the size of the first. Faults are added to the problems.
std::vector<Image<glm::vec3>> read_pictures(const std::vector<std::string>& files, glm::ivec2& size, double& quantum,
                                            Problems& problems) {
  std::vector<Image<glm::vec3>> pictures;
  for (const auto& file : files) {
    auto photograph = read_photograph(file);
    if (!photograph) {
      problems.add("{}", photograph.error().message);
      continue;
    }
    const glm::ivec2 own{photograph->encoded.width(), photograph->encoded.height()};
    if (size.x == 0) size = own;
    if (own != size) {
      problems.add("{}: {} x {}, expected {} x {} like the first picture: one camera, one size", file, own.x, own.y,
                   size.x, size.y);
      continue;
    }
    if (!(photograph->quantum > 0.0))
      problems.add("{}: expected the camera's own 8 or 16 bits, not floating point", file);
    quantum = photograph->quantum;
    pictures.push_back(std::move(photograph->encoded));
  }
  return pictures;
}

Result<int> calibrate(const ResponseArguments& arguments) {
  if (auto sound = check(arguments); !sound) return fail(sound.error());
  Problems problems;
  glm::ivec2 size{0};
  ExposureStack stack;
  stack.pictures = read_pictures(arguments.pictures, size, stack.quantum, problems);
  double dark_quantum = stack.quantum, flat_quantum = stack.quantum;
  const auto darks = read_pictures(arguments.darks, size, dark_quantum, problems);
  const auto flats = read_pictures(arguments.flats, size, flat_quantum, problems);
  if (!problems.empty()) return fail(problems.fault());
  for (const auto& file : arguments.pictures) stack.names.push_back(std::filesystem::path(file).filename().string());

  MeasuredResponse found;
  found.dark = measure_dark_frame(darks, stack.quantum);
  auto mask = circle_mask(arguments.circle, size);
  if (mask.empty() && !found.dark.hot.empty()) mask = Image<std::uint8_t>(size.x, size.y, 255);
  for (const auto& hot : found.dark.hot) mask.at(hot.x, hot.y) = 0;
  if (auto one = check_one_view(stack, mask); !one) return fail(one.error());
  const auto known =
      known_exposures(std::move(stack), arguments.exposures_s, arguments.exposure_percent, found.dark.black, mask);
  if (known.stack.pictures.size() < 2)
    return fail(FaultKind::bad_input,
                "no two of the {} pictures overlap: expected exposures each 2 to 4 times the one before",
                arguments.pictures.size());
  if (auto differ = check_exposure_ratios(known); !differ) return fail(differ.error());
  const auto samples = sample_stack(known.stack.pictures, known.stack.quantum, found.dark.black, mask, kStackPixels);
  auto calibration = calibrate_response(samples, known.exposures);
  if (!calibration) return fail(calibration.error());
  if (auto close = check_prediction(*calibration, samples, known); !close) return fail(close.error());
  found.calibration = std::move(*calibration);
  found.curve = curve_of(found.calibration, found.dark.black);
  found.noise = fit_noise(samples, found.calibration.fit);
  if (!flats.empty()) {
    const auto response = found.curve.linear() ? Response::linear() : Response::table(found.curve.light);
    auto vignetting = fit_flat_fields(flats, response, arguments.circle, mask);
    if (!vignetting) return fail(vignetting.error().kind, "--flat: {}", vignetting.error().message);
    found.vignetting = *vignetting;
  }
  remark(found, arguments, known);
  report(known, found);

  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  const auto title = fmt::format("{}: predicts unseen pixels to {:.2f} steps", found.calibration.fit.method,
                                 found.calibration.held_out_steps);
  if (!arguments.merged.empty()) {
    const auto merged = merge_stack(known.stack.pictures, known.stack.quantum, found.dark.black, found.calibration.fit,
                                    found.noise.value_or(NoiseModel{}));
    if (auto written = write_light_file(arguments.merged, merged); !written) return fail(written.error());
    fmt::print("merged: {}: linear light, the longest exposure's full scale is 1\n", arguments.merged);
  }

  CalibrationStep step;
  step.camera = arguments.camera;
  step.width = size.x;
  step.height = size.y;
  step.serial = arguments.serial;
  step.curve = found.curve;
  if (found.vignetting) step.vignetting = found.vignetting->vignetting;
  if (found.noise && found.noise->shot > 1e-7 && arguments.camera == "scene")
    step.noise = {found.noise->full_scale_electrons(), found.noise->read_electrons()};
  step.calibrated_utc = now;
  step.measured = measured_of(arguments, known, found, now);
  return save_calibration(arguments.out, std::move(step), plot_response(found.calibration.fit, samples, title));
}

}  // namespace

void add_calibrate_response(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "response", "How pixel values follow light, noise, black level and vignetting, from exposures of one view");
  auto arguments = std::make_shared<ResponseArguments>();
  auto& a = *arguments;
  command->add_option("picture", a.pictures,
                      "One view, camera and scene still, in exposures from too dark to too bright");
  command->add_option("--exposures-s", a.exposures_s, "Their exposure times; default: estimated from the pictures")
      ->type_name("S,S,...")
      ->delimiter(',');
  command
      ->add_option("--exposure-percent", a.exposure_percent,
                   "Uncertainty of each time, one standard deviation; 0: exact")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command->add_option("--dark", a.darks, "Pictures with the lens covered: black level and hot pixels");
  command->add_option("--flat", a.flats, "Pictures of an evenly lit surface that fills the frame: vignetting");
  command->add_option("--circle", a.circle, "Use only this circle: centre and radius in pixels")
      ->type_name("CX,CY,R")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--camera", a.camera, "The camera whose response is measured")
      ->check(CLI::IsMember({"sky", "scene"}))
      ->capture_default_str();
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command->add_option("--merged", a.merged,
                      "Also write the stack merged into one picture of linear light (.tiff, .exr, .pfm or .hdr)");
  command->add_option("--out", a.out, "The calibration file; an older one is kept as a backup")->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi
