// The sky camera's half of the pipeline: from its frames to today's air.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "capture/frame.hpp"
#include "estimator/sun_in_image.hpp"
#include "estimator/tracker.hpp"
#include "estimator/turbidity.hpp"
#include "pipeline/installation.hpp"

namespace kasumi {

// What one sky frame taught us; the renderer reads the latest of these.
struct SkyReport {
  Utc utc{};
  TurbidityEstimate estimate;               // of this frame
  std::optional<TrackedTurbidity> tracked;  // over time; empty until the first usable estimate
  std::optional<AirQuality> air;            // of the tracked turbidity
  SunCheck sun;
  std::shared_ptr<const DecodedPicture> picture;  // the frame's pixels; null before the first frame
};

struct SkyWatchOptions {
  bool clock_trusted = true;
  EstimateOptions estimate;
};

// Belongs to one thread.
class SkyWatch {
 public:
  explicit SkyWatch(const Installation& installation, SkyWatchOptions options = {});

  // Errors (bad_input): a frame without a picture: truncated, flagged, damaged, of another size. The watch goes on.
  Result<SkyReport> observe(const Frame& frame);

 private:
  SunCheck find_sun_for(Utc utc, const SkyPicture& picture) const;

  Site site_;
  SkyWatchOptions options_;
  SkyObserver observer_;
  TurbidityTracker tracker_;
};

}  // namespace kasumi
