// One look at the sky: from a picture to T, or to the reason why not.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/cloud_mask.hpp"
#include "estimator/turbidity/measured_sky.hpp"
#include "estimator/turbidity/sky_picture.hpp"
#include "estimator/turbidity/sky_samples.hpp"
#include "estimator/turbidity/solver.hpp"

namespace kasumi {

enum class EstimateMethod {
  free_gain,        // ours: global, robust, the gain solved along with T
  reference_pixel,  // the papers': M Eq 8 with one reference pixel
};

struct EstimateOptions {
  EstimateMethod method = EstimateMethod::free_gain;
  int samples = 400;       // N
  std::uint64_t seed = 1;  // of the drawn samples
  bool mask_clouds = true;
  SampleLimits limits;
  CloudMaskOptions clouds;
  SolverOptions solver;
  SkyToFit sky;  // the papers' method knows Preetham's alone
  ReferencePixelOptions reference;
  // When an estimate is believed.
  Radians lowest_sun = from_degrees(3.0);  // elevation
  double least_clear_fraction = 0.10;      // of the sky looked at
  int least_samples = 60;                  // that agree
  double least_agreement = 0.40;           // of the drawn samples that agree
  double largest_log_residual = 0.16;      // real clear skies leave 0.07 .. 0.09
  double largest_relative_sigma = 0.20;    // sigma / T
};

// An estimate with everything that led to it, for a plot or a report.
struct SkyLook {
  TurbidityEstimate estimate;
  SkyToFit sky;  // whose T it is
  std::vector<SkySample> samples;
  std::vector<glm::ivec2> elements;  // of the SkyPicture, one per sample
  std::vector<std::uint8_t> inlier;  // one per sample
  double log_gain = 0.0;             // ln(measured / model): model_i = log_gain + ln F(sample i; T)
  Image<PixelUse> use;               // of every element of the SkyPicture
};

// Keeps what depends on the camera alone, so that a stream of pictures pays for it once. Not for two threads at once.
class SkyObserver {
 public:
  explicit SkyObserver(Camera camera) : camera_(std::move(camera)) {}
  SkyLook look(const SkyPicture& picture, const SunDirection& sun, const EstimateOptions& options = {});
  // The sky of a picture that has been looked at, for the light on an object; empty when it shows too little of it to
  // say more than the model does. `through`: where a cloud would shade the object.
  std::optional<MeasuredSky> measure(const SkyPicture& picture, const SkyLook& look, const Direction& through);
  const Camera& camera() const { return camera_; }

 private:
  Camera camera_;
  std::optional<SkyGeometry> geometry_;
};

// The same for a single picture.
TurbidityEstimate estimate_turbidity(const SkyPicture& picture, const Camera& camera, const SunDirection& sun,
                                     const EstimateOptions& options = {});

}  // namespace kasumi
