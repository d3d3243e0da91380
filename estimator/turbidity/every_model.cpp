#include "estimator/turbidity/every_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/square.hpp"
#include "base/statistics.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/turbidity/cloud_mask.hpp"
#include "estimator/turbidity/picture_readings.hpp"

namespace kasumi {

namespace {

constexpr double kFewWrong = 0.01;    // of the readings: a fit by medians does not see them
constexpr double kSmallError = 0.01;  // of ln Y: no real sky is as near to a model

SiteSky sky_of(const ModelToFit& sky, Turbidity turbidity, const SunDirection& sun) {
  return {sky.model, sky.aerosol ? AirState(*sky.aerosol) : AirState(turbidity), sun, sky.altitude_m};
}

ExpectedLook expected_by(const SiteSky& sky, const ElementGeometry& geometry) {
  return [&sky, xyz_to_light = glm::inverse(geometry.light_to_xyz)](const Direction& view) -> glm::vec2 {
    const glm::dvec3 xyz = sky.relative_xyz(view), light = xyz_to_light * xyz;
    return {std::log(xyz.y), std::log(light.r / light.b)};
  };
}

// Begins with what Preetham's sky takes for clear; where few places then agree, clouds in haze or dust, with what domes
// of other aerosols do.
ClearAir find_clear_air(ElementLight& sky, const ElementLooks& looks, const ElementGeometry& geometry,
                        const SunDirection& sun, const EstimateParameters& options) {
  constexpr double kAgree = 0.5;  // with half of the sky in agreement no other aerosol's dome is tried
  const double altitude_m = options.sky.altitude_m;
  const auto dome_of = [&](AerosolKind kind) -> ModelToFit {
    return {DaylightModel::dome, altitude_m, Aerosol{0.0, natural_exponent(kind), kind}};
  };
  ClearAir best;
  const Image<PixelUse> unmarked = sky.use;
  const CloudMasks masks(sky, looks, geometry, sun, options.clouds);
  Image<PixelUse> marked = sky.use;
  for (const ModelToFit& model : {ModelToFit{}, dome_of(AerosolKind::continental), dome_of(AerosolKind::dust)}) {
    sky.use = unmarked;
    const ClearAir air = mask_all_but_clear_air(sky, looks, geometry, masks.by(model), sun);
    if (air.found && (!best.found || air.agreement > best.agreement)) best = air, marked = sky.use;
    if (best.agreement > kAgree) break;
  }
  sky.use = std::move(marked);
  return best;
}

// What samples, inliers and gain are under the sky that is followed: for plots and for the verdict.
void compare_with_followed(TurbidityObservation& observation, VerdictEvidence& evidence, const SunDirection& sun) {
  const FittedSky fitted(observation.sky, sun);
  const std::vector<LuminanceSample>& samples = observation.samples;
  std::vector<double> residuals(samples.size());
  FittedPlaces(samples, fitted).at(evidence.fit.turbidity, [&](std::size_t i, double log_f, double) {
    residuals[i] = static_cast<double>(samples[i].log_luminance) - log_f;
  });
  observation.log_gain = median(residuals);
  for (double& r : residuals) r -= observation.log_gain;
  // Robust standard deviations, and no stricter than 5 %: models err by as much.
  constexpr double kReach = 3.5, kLeast = 0.05;
  const double limit = std::max(kLeast, kReach * robust_sigma(residuals));
  observation.inlier.assign(samples.size(), 0);
  for (std::size_t i = 0; i < samples.size(); ++i) observation.inlier[i] = std::abs(residuals[i]) <= limit ? 1 : 0;
  evidence.agreeing = static_cast<int>(std::ranges::count(observation.inlier, 1));

  TurbiditySolution solution;
  solution.turbidity = evidence.fit.turbidity;
  solution.log_gain = observation.log_gain;
  solution.inlier = observation.inlier;
  solution.inliers = evidence.agreeing;
  evidence.rivals = compare_skies(samples, solution, fitted);
}

// By how much ln Y grows where all of an element's values are half a step more: a camera that cuts its values off instead
// of rounding them leaves out so much, which no scatter shows.
float half_a_step(const glm::ivec2& element, const SkyPicture& picture, const ElementGeometry& geometry,
                  const Camera& camera) {
  const glm::dvec3 encoded(picture.encoded.at(element.x, element.y)), gain(geometry.gain.at(element.x, element.y));
  const glm::dmat3& to_xyz = geometry.light_to_xyz;
  const glm::dvec3 luminance = glm::dvec3{to_xyz[0].y, to_xyz[1].y, to_xyz[2].y} * gain;
  const double more = 0.5 * picture.quantum * glm::dot(luminance, camera.response.slope(encoded));
  return static_cast<float>(more / glm::dot(luminance, camera.response.to_light(encoded)));
}

// Standard deviation of T by an offset of all values anywhere within half a step. `half_steps`: of each sample.
double sigma_of_offset(std::vector<LuminanceSample> samples, std::span<const float> half_steps,
                       const TurbiditySolution& solution) {
  std::vector<double> weights(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (solution.inlier[i] != 0)
      weights[i] = 1.0 / (square(static_cast<double>(samples[i].sigma)) + square(solution.model_error) + 1e-10);
  const double as_read = refine_turbidity(samples, weights, solution.turbidity).turbidity.value;
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].log_luminance += half_steps[i];
  const double with_offset = refine_turbidity(samples, weights, solution.turbidity).turbidity.value;
  return std::abs(with_offset - as_read) / std::sqrt(3.0);
}

// Where Preetham's sky fits exactly, his own fit of luminance alone is more precise, and what users of T expect.
// `readings`: one per sample; their light is a mean, of which rounding and noise leave about half.
void sharpen_papers(SkyFit& fit, std::span<const LuminanceSample> samples, std::span<const SkyReading> readings,
                    std::span<const float> half_steps, const EstimateParameters& options) {
  constexpr float kLeft = 0.5f;  // of rounding and noise, see above
  const glm::dmat3 to_xyz = glm::inverse(xyz_to_linear_srgb());
  std::vector<LuminanceSample> apart;
  std::vector<float> apart_half_steps;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    LuminanceSample sample = samples[i];
    if (static_cast<double>(sample.sun_distance) < options.limits.least_sun_distance.value) continue;
    sample.log_luminance = static_cast<float>(std::log((to_xyz * readings[i].light).y));
    sample.sigma *= kLeft;
    sample.quantisation *= kLeft;
    apart.push_back(sample);
    apart_half_steps.push_back(half_steps[i]);
  }
  const TurbiditySolution papers = solve_turbidity(apart, options.solver);
  if (!papers.solved || papers.model_error > kSmallError) return;
  const double sigma = std::hypot(papers.sigma, sigma_of_offset(apart, apart_half_steps, papers));
  fit.turbidity = papers.turbidity;
  fit.sigma_turbidity = sigma;
  const double per_turbidity = aerosol_of(3.0).aod_550 - aerosol_of(2.0).aod_550;
  fit.found.aerosol.aod_550 = aerosol_of(papers.turbidity.value).aod_550;
  fit.found.covariance.aod_550 = square(per_turbidity * sigma);
}

// What the camera may do to the light is not sure either.
void doubt_camera(SkyFit& fit, double doubt_of_aod) {
  constexpr double kStep = 0.01;  // of a numerical derivative by optical depth
  Aerosol more = fit.found.aerosol;
  more.aod_550 += kStep;
  const double per_aod = (turbidity_of(more) - turbidity_of(fit.found.aerosol)) / kStep;
  fit.found.covariance.aod_550 += doubt_of_aod * doubt_of_aod;
  fit.sigma_turbidity = std::hypot(fit.sigma_turbidity, per_aod * doubt_of_aod);
}

VerdictEvidence ask_every_model(TurbidityObservation& observation, ElementLight sky,
                                const ExposureStatistics& statistics, const SkyPicture& picture,
                                const ElementGeometry& geometry, const Camera& camera,
                                const EstimateParameters& options) {
  VerdictEvidence evidence;
  evidence.statistics = statistics;
  const SunDirection sun = observation.estimate.sun;
  const InstrumentDoubt doubt = doubt_of(camera);
  std::mt19937_64 random(options.seed);
  ElementReadings drawn;
  const auto fit = [&] {
    SampleLimits limits = options.limits;
    limits.least_sun_distance = kNearestToSun;
    drawn =
        readings_at(draw_elements(sky, geometry, options.samples, random), picture, geometry, sky, camera, sun, limits);
    observation.elements = drawn.elements;
    observation.samples = samples_at(observation.elements, picture, geometry, sky, camera, sun, limits);
    evidence.readings = static_cast<int>(drawn.readings.size());
    evidence.fit = fit_sky(drawn.readings, sun, options.sky, doubt);
    if (evidence.fit.solved) observation.sky = followed(evidence.fit, options.sky);
  };

  if (!options.mask_clouds) {
    evidence.air.found = true;
    evidence.air.clear_fraction = 1.0;
    fit();
  } else {
    const ElementLooks looks = looks_of(picture, camera, sky);
    evidence.bluest =
        static_cast<double>(quantile(some_of(looks, [&](int x, int y) { return looks.colour(y, x); }), 0.1));
    evidence.air = find_clear_air(sky, looks, geometry, sun, options);
    if (evidence.air.found) fit();
    if (evidence.fit.solved) {
      // The form is laid over the sky that was found, so that it shows thin edges as well.
      const SiteSky model = sky_of(observation.sky, evidence.fit.turbidity, sun);
      const ClearAirLimits fine{.window = {0.15f, 0.02f, 5}, .least = 0.01};
      evidence.air = mask_all_but_clear_air(sky, looks, geometry, Image<PixelUse>(sky.use), sun, fine,
                                            expected_by(model, geometry));
      const auto cloud = std::ranges::count_if(
          drawn.elements, [&sky](const glm::ivec2& e) { return sky.use.at(e.x, e.y) != PixelUse::clear; });
      if (static_cast<double>(cloud) > kFewWrong * evidence.readings) fit();
    }
  }
  observation.use = std::move(sky.use);
  if (!evidence.fit.solved) return evidence;
  if (observation.sky.model == DaylightModel::preetham) {
    std::vector<float> half_steps;
    for (const glm::ivec2& e : drawn.elements) half_steps.push_back(half_a_step(e, picture, geometry, camera));
    sharpen_papers(evidence.fit, observation.samples, drawn.readings, half_steps, options);
  }
  compare_with_followed(observation, evidence, sun);
  if (evidence.fit.log_residual > kNearSky) {
    evidence.fault = find_fault(drawn.readings, sun, options.sky.altitude_m);
    // Models leave some twentieths of any real sky: only what a camera's fault explains far better is its.
    if (evidence.fault.found) doubt_camera(evidence.fit, evidence.fault.doubt_of_aod);
  }

  observation.readings = std::move(drawn.readings);
  TurbidityEstimate& estimate = observation.estimate;
  estimate.turbidity = evidence.fit.turbidity;
  estimate.sigma = evidence.fit.sigma_turbidity;
  estimate.log_residual = evidence.fit.log_residual;
  estimate.found = evidence.fit.found;
  for (const ModelFit& model : evidence.fit.models) estimate.models.push_back(model.answer);
  estimate.samples = evidence.agreeing;
  const auto samples = static_cast<double>(observation.samples.size());
  estimate.clear_fraction = samples > 0.0 ? evidence.air.clear_fraction * evidence.agreeing / samples : 0.0;
  return evidence;
}

}  // namespace

std::optional<Refusal> observe_by_every_model(TurbidityObservation& observation, ElementLight sky,
                                              const ExposureStatistics& statistics, const SkyPicture& picture,
                                              const ElementGeometry& geometry, const Camera& camera,
                                              const EstimateParameters& options) {
  const SunDirection sun = observation.estimate.sun;
  const ColourStatistics look = options.mask_clouds ? look_of(picture, geometry, sky, sun) : ColourStatistics{};
  if (auto refusal = refuse_by_look(look, statistics.brightest)) {
    std::ranges::replace(sky.use.elements(), PixelUse::clear, PixelUse::cloud);
    observation.use = std::move(sky.use);
    return refusal;
  }
  SampleLimits nearer = options.limits;
  nearer.least_sun_distance = std::min(nearer.least_sun_distance, kNearestToSun);
  read_nearer(sky, picture, geometry, sun, nearer);
  VerdictEvidence evidence =
      ask_every_model(observation, std::move(sky), statistics, picture, geometry, camera, options);
  evidence.look = look;
  double& clear_fraction = observation.estimate.clear_fraction;
  if (look.places >= kFewestPlaces) clear_fraction = std::min(clear_fraction, look.smooth);
  return refuse_by_evidence(evidence, options);
}

ModelToFit followed(const SkyFit& fit, ModelToFit sky) {
  if (fit.found.papers_share > 0.5) {
    sky.model = DaylightModel::preetham;
    sky.aerosol.reset();
  } else {
    sky.model = DaylightModel::dome;
    sky.aerosol = fit.found.aerosol;
  }
  return sky;
}

}  // namespace kasumi
