// From one sky picture to T, or to the reason why there is none.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/camera_belief.hpp"
#include "estimator/sky_fit/sky_reading.hpp"
#include "estimator/turbidity/cloud_mask.hpp"
#include "estimator/turbidity/measured_sky.hpp"
#include "estimator/turbidity/sky_picture.hpp"
#include "estimator/turbidity/sky_samples.hpp"
#include "estimator/turbidity/solver.hpp"

namespace kasumi {

using TurbiditySolver = std::function<TurbiditySolution(std::span<const LuminanceSample>)>;

struct EstimateParameters {
  int samples = 400;       // N
  std::uint64_t seed = 1;  // of the drawn samples
  bool mask_clouds = true;
  SampleLimits limits;
  CloudMaskLimits clouds;
  SolverWindows solver;
  ModelToFit sky;
  TurbiditySolver solve;  // instead of solve_turbidity(), of Preetham's sky alone: estimator/papers
  // Conditions for accepting an estimate.
  Radians lowest_sun = from_degrees(3.0);  // elevation
  double least_clear_fraction = 0.10;      // of the sky examined
  int least_samples = 60;                  // that agree
  double least_agreement = 0.40;           // of the drawn samples that agree
  double largest_log_residual = 0.16;      // real clear skies leave 0.07 .. 0.09
  double largest_relative_sigma = 0.20;    // sigma / T
};

// An estimate with all its intermediate results, for a plot or a report.
struct TurbidityObservation {
  TurbidityEstimate estimate;
  ModelToFit sky;  // the model to which T belongs
  std::vector<LuminanceSample> samples;
  std::vector<glm::ivec2> elements;  // of the SkyPicture, one per sample
  std::vector<std::uint8_t> inlier;  // one per sample
  double log_gain = 0.0;             // ln(measured / model): model_i = log_gain + ln F(sample i; T)
  Image<PixelUse> use;               // of every element of the SkyPicture
  std::vector<SkyReading> readings;  // of clear air, where every model was asked
  // By observe_by_unknown_camera(): d ln(light as read) / d ln(light) by the camera's supposed response; 0: not sought.
  double tone_exponent = 0.0, sigma_tone_exponent = 0.0;
  double rim_loss = 0.0, sigma_rim_loss = 0.0;  // by the same, of ln light at the lens' edge
};

// Keeps what depends on the camera alone, so that it is computed once for a stream of pictures. Not thread-safe.
class SkyObserver {
 public:
  explicit SkyObserver(Camera camera) : camera_(std::move(camera)) {}
  TurbidityObservation observe(const SkyPicture& picture, const SunDirection& sun,
                               const EstimateParameters& options = {});
  // The same where neither response nor vignetting of the camera was measured: both are unknowns beside the air, and the
  // estimate's sigma holds what they leave uncertain. It is refused only where that is more than the aerosol depth itself
  // and .2. `clear_air`: as the picture's elements, 1 where colours show neither cloud nor land.
  TurbidityObservation observe_by_unknown_camera(const SkyPicture& picture, const SunDirection& sun,
                                                 const Image<std::uint8_t>& clear_air, const CameraBelief& belief,
                                                 const EstimateParameters& options = {});
  // The sky of a picture after observe(), for the light on an object; empty when too little of it is visible to improve
  // on the model. `through`: where a cloud would shade the object.
  std::optional<MeasuredSky> measure(const SkyPicture& picture, const TurbidityObservation& observation,
                                     const Direction& through);
  const Camera& camera() const { return camera_; }

 private:
  Camera camera_;
  std::optional<ElementGeometry> geometry_;
};

// The same for a single picture.
TurbidityEstimate estimate_turbidity(const SkyPicture& picture, const Camera& camera, const SunDirection& sun,
                                     const EstimateParameters& options = {});

}  // namespace kasumi
