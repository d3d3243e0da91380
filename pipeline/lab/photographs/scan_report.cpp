#include "pipeline/lab/photographs/scan_report.hpp"

#include "estimator/sky/sun.hpp"
#include "estimator/sky_fit/scanned_sky.hpp"
#include "estimator/turbidity/sky_verdict.hpp"
#include "pipeline/lab/photographs/found_air.hpp"
#include "pipeline/lab/photographs/scan_readings.hpp"

namespace kasumi {
namespace {

// Scanners are calibrated against lamps: colours within some percent, and no lens to darken the edge.
constexpr double kScannerWhiteBalance = 0.05;

}  // namespace

Result<ScanReport> report_on_scan(const std::filesystem::path& file, const PhotographSetup& options) {
  const auto scan = read_scan_readings(file);
  if (!scan) return fail(scan.error());
  ScanReport report;
  report.note = scan->note;
  auto& answer = report.answer;
  const auto sun = options.sun ? *options.sun : sun_position(*options.utc, *options.site).direction;
  answer.sun.direction = sun;
  answer.look.sky = options.estimate.sky;
  answer.look.estimate.sun = sun;
  if (const auto refusal = refuse_by_sun(sun, options.estimate)) {
    answer.look.estimate.sky = refusal->sky;
    answer.look.estimate.reason = refusal->reason;
    return report;
  }
  const InstrumentDoubt scanner{scan->colours, kScannerWhiteBalance, 0.0};
  auto found = estimate_from_scan(scan->readings, sun, options.estimate.sky, scanner);
  answer.look.estimate = std::move(found.estimate);
  answer.look.sky = std::move(found.sky);
  if (answer.look.estimate.usable) {
    answer.air = found_air(answer.look.estimate, answer.look.sky);
    answer.quality = air_quality(*answer.air, options.estimate.sky.altitude_m);
  }
  return report;
}

}  // namespace kasumi
