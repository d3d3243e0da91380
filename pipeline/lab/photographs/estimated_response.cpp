#include "pipeline/lab/photographs/estimated_response.hpp"

namespace kasumi {

Result<ToneCurve> tone_curve_of(std::span<const DatedFile> taken, PhotographSetup options) {
  // Under every model of the sky, whichever is chosen for the air.
  options.estimate.sky.every_model = true;
  const double altitude_m = options.site ? options.site->altitude_m : options.estimate.sky.altitude_m;
  PhotographEstimator photographs(std::move(options));
  std::vector<ToneEvidence> pictures;
  for (const DatedFile& one : taken) {
    auto report = photographs.estimate_from(one.file, one.utc);
    if (!report) return fail(report.error());
    const TurbidityEstimate& estimate = report->look.estimate;
    const bool cloudless = estimate.sky == SkyCondition::clear || estimate.sky == SkyCondition::unknown;
    pictures.push_back({cloudless ? std::move(report->look.readings) : std::vector<SkyReading>{}, estimate.sun});
  }
  return find_tone_curve(pictures, altitude_m);
}

}  // namespace kasumi
