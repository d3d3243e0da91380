#include "pipeline/lab/haze/haze_options.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <spdlog/spdlog.h>

#include "base/finite_number.hpp"
#include "estimator/photograph/other_air.hpp"

namespace kasumi {
namespace {

// "2.5" or "2:8:.25": from, to, step.
std::optional<std::vector<double>> numbers(const std::string& text, double least, double most) {
  std::vector<double> parts, values;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ':');) {
    const auto value = finite_number(part);
    if (!value) return std::nullopt;
    parts.push_back(*value);
  }
  const auto good = [&](double value) { return value >= least && value <= most; };
  if (parts.size() == 1 && good(parts[0])) return parts;
  if (parts.size() != 3 || !good(parts[0]) || !good(parts[1]) || parts[2] <= 0.0 || parts[0] >= parts[1] ||
      (parts[1] - parts[0]) / parts[2] > 10e3)
    return std::nullopt;
  for (int i = 0; parts[0] + i * parts[2] <= parts[1] + 1e-9; ++i)
    values.push_back(std::min(parts[0] + i * parts[2], parts[1]));
  return values;
}

std::vector<HazeValues> read_values(const HazeOptions& options, Problems& problems) {
  std::vector<HazeValues> all;
  const bool by_air = !options.turbidities.empty() || !options.aods.empty();
  if ((options.turbidities.empty() ? 0 : 1) + (options.aods.empty() ? 0 : 1) + (options.scatterings.empty() ? 0 : 1) !=
      1)
    problems.add("expected --turbidity T, --aod, or --kappa-s (and --kappa-a): one of them describes the haze");
  if (by_air && options.kappa_a) problems.add("--kappa-a: not allowed with --turbidity or --aod");
  if (!by_air && options.aerosol.any())
    problems.add("--angstrom, --aerosol: expected together with --turbidity or --aod");
  const GivenAir given = options.aerosol.given();
  for (const auto& text : options.turbidities) {
    const auto list = numbers(text, kLowestTurbidity.value, kHighestTurbidity.value);
    if (!list) problems.add("--turbidity {}: expected a T of 1.7 to 20, or FROM:TO:STEP", text);
    for (const double t : list.value_or(std::vector<double>{}))
      all.push_back({Turbidity{t}, 0.0, 0.0, options.lambda, given.to_be_found()});
  }
  for (const auto& text : options.aods) {
    const auto list = numbers(text, 0.0, kHighestGivenAod);
    if (!list) problems.add("--aod {}: expected an optical depth of 0 to 1.8, or FROM:TO:STEP", text);
    for (const double aod : list.value_or(std::vector<double>{})) {
      const Aerosol aerosol = given.with(aod);
      all.push_back({Turbidity{turbidity_of(aerosol)}, 0.0, 0.0, options.lambda, aerosol});
    }
  }
  for (const auto& text : options.scatterings) {
    const auto list = numbers(text, 0.0, 100.0);
    if (!list) problems.add("--kappa-s {}: expected 0 to 100 per farthest range, or FROM:TO:STEP", text);
    for (const double s : list.value_or(std::vector<double>{}))
      all.push_back({std::nullopt, options.kappa_a.value_or(0.0), s, options.lambda, std::nullopt});
  }
  return all;
}

// `picture`: null where it could not be read.
std::optional<Image<float>> read_range(const HazeOptions& options, const Image<glm::vec3>* picture,
                                       Problems& problems) {
  if (options.distances.ways() != 1) {
    problems.add(
        "expected --depth FILE, --disparity FILE with --disparity-scale, or --inverse-depth FILE with --inverse-scale");
    return std::nullopt;
  }
  if (!picture) return std::nullopt;
  auto read = read_distances(options.distances, false, picture->width(), picture->height(), problems);
  if (!read) return std::nullopt;
  return std::move(read->metres);
}

Image<glm::vec3> light_of(const Camera& camera, const Image<glm::vec3>& encoded) {
  Image<glm::vec3> light(encoded.width(), encoded.height());
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) light.at(x, y) = camera.light_at({x, y}, glm::dvec3(encoded.at(x, y)));
  return light;
}

// H assumes one airlight for the whole picture.
Result<glm::dvec3> measured_airlight(const Camera& camera, const Photograph& photograph, const std::string& name) {
  const auto horizon = horizon_of(camera, photograph, name);
  if (!horizon) return fail(horizon.error());
  glm::dvec3 sum{0.0};
  for (const auto& column : horizon->columns) sum += column.light;
  return sum / static_cast<double>(horizon->columns.size());
}

// Where there is no sky, what lights a room: the mean of the brightest hundredth of the picture.
glm::dvec3 light_of_walls(const Camera& camera, const Photograph& photograph) {
  const auto light = light_of(camera, photograph.encoded);
  std::vector<glm::vec3> all(light.elements().begin(), light.elements().end());
  const auto count = std::max<std::size_t>(1, all.size() / 100);
  const auto brightness = [](const glm::vec3& c) { return c.r + c.g + c.b; };
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(count - 1), std::greater{}, brightness);
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < count; ++i) sum += glm::dvec3(all[i]);
  const auto mean = glm::max(sum / static_cast<double>(count), glm::dvec3(1e-3));
  fmt::print("airlight {:.3f},{:.3f},{:.3f}: of the picture's brightest hundredth, for there is no sky indoors\n",
             mean.r, mean.g, mean.b);
  return mean;
}

}  // namespace

std::string HazeValues::name() const {
  if (turbidity) return name_of(air_of(*turbidity, like));
  return fmt::format("a{:.2f}-s{:.2f}", kappa_a, kappa_s);
}

HazeOptics HazeTask::optics_of(const HazeValues& haze) const {
  if (!haze.turbidity) return haze_optics(haze.kappa_a, haze.kappa_s, haze.lambda);
  return haze_optics(nodes, scattering, air_of(*haze.turbidity, haze.like), altitude_m, range.farthest_m, haze.lambda);
}

Result<HazeTask> haze_task(const HazeOptions& options) {
  Problems problems;
  HazeTask task;
  task.values = read_values(options, problems);
  task.scheme = diffusion_scheme_named(options.scheme).value_or(DiffusionScheme::matched);
  const std::optional<Aerosol> like = task.values.empty() ? std::nullopt : task.values.front().like;
  task.scattering = scattering_model_named(options.scattering)
                        .value_or(like ? ScatteringModel::aerosol : ScatteringModel::morales2017);
  task.altitude_m = options.altitude_m;
  std::string damage;
  auto photograph = read_photograph(options.picture, options.allow_damaged ? &damage : nullptr);
  if (!photograph) problems.add("{}", photograph.error().message);
  if (!damage.empty()) spdlog::warn("{}: {}; what is left of it is used", options.picture, damage);
  auto range_m = read_range(options, photograph ? &photograph->encoded : nullptr, problems);
  std::optional<SpectralSensitivity> sensitivity;
  if (!options.sensitivity.empty()) {
    auto read = read_spectral_sensitivity(options.sensitivity);
    if (read)
      sensitivity = std::move(*read);
    else
      problems.add("{}", read.error().message);
  }
  if (range_m) {
    auto range_options = options.range;
    if (options.indoors) range_options.smallest_sky_share = 1.0;
    range_options.outline_reach_px =
        options.outline_reach_px.value_or(std::clamp(static_cast<int>(std::lround(0.01 * range_m->width())), 3, 64));
    auto prepared = prepare_range(*range_m, range_options, photograph->encoded);
    if (prepared)
      task.range = std::move(*prepared);
    else
      problems.add("{}", prepared.error().message);
  }
  // What is near is as blurred as its own way through the haze makes it, its outline too.
  if (!options.cut_outlines)
    task.range.steps_along_row = task.range.steps_down_column =
        Image<float>(task.range.range.width(), task.range.range.height());
  if (photograph) {
    task.camera = plain_camera(photograph->encoded.width(), photograph->encoded.height(),
                               from_degrees(options.field_of_view_deg), from_degrees(options.pitch_deg));
    if (sensitivity) task.camera.sensitivity = *sensitivity;
    if (options.airlight.size() == 3)
      task.airlight = {options.airlight[0], options.airlight[1], options.airlight[2]};
    else if (const auto measured = measured_airlight(task.camera, *photograph, options.picture))
      task.airlight = *measured;
    else if (options.indoors)
      task.airlight = light_of_walls(task.camera, *photograph);
    else
      problems.add("{}", measured.error().message);
  }
  if (!problems.empty()) return fail(problems.fault());
  task.photograph = std::move(*photograph);
  task.light = light_of(task.camera, task.photograph.encoded);
  task.nodes = attenuation_nodes(spectral_measure(task.camera), task.scattering, air_of(Turbidity{}, like));
  return task;
}

}  // namespace kasumi
