// From the sky camera's frames, and from what the scene camera shows of the air, to today's air.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "capture/frame.hpp"
#include "estimator/fusion/air_tracker.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "pipeline/show/scene/scene_watch.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

// Result of one sky frame; the renderer uses the latest.
struct SkyReport {
  Utc utc{};
  TurbidityEstimate estimate;              // of this frame
  std::optional<TrackedAir> air;           // over time, by all observers: drives the picture; empty: none was tracked
  std::optional<double> scene_saturation;  // learnt of the scene camera; empty: nothing was
  SunCheck sun;
  std::shared_ptr<const MeasuredSky> measured;    // this frame's clouds; null: nothing beyond the model
  std::shared_ptr<const DecodedPicture> picture;  // the frame's pixels; null when there is no frame

  const TrackedAir* seen_air() const { return air && air->seen() ? &*air : nullptr; }  // null: no observer has seen it
};

using TurbidityEstimator = std::function<TurbidityEstimate(const SkyPicture&, const SunDirection&)>;

struct ObservationPlan {
  EstimateParameters estimate;                       // except its sky, which is the site's
  TurbidityEstimator estimator;                      // replaces the built-in one, for tests
  Duration observe_every = std::chrono::seconds(1);  // of an appliance; air changes in minutes
};

// What a frame of the sky camera shows by itself, whatever came before it. Belongs to one thread.
class FrameReader {
 public:
  explicit FrameReader(const Installation& installation, ObservationPlan options = {});

  // The report of a frame, which lacks the air. Arguments and errors: as SkyWatch::observe().
  Result<SkyReport> read(const Frame& frame, SunSource sun_from);
  // `picture`: null: there is none.
  SunCheck place_sun(Utc utc, const SkyPicture* picture, SunSource sun_from) const;
  const ModelToFit& sky() const { return options_.estimate.sky; }

 private:
  void estimate(const SkyPicture& picture, SkyReport& report);

  Site site_;
  glm::dvec3 object_m_;  // clouds in front of the sun may shade it
  double cloud_base_m_;
  ObservationPlan options_;
  SkyObserver observer_;
};

// Belongs to one thread.
class SkyWatch {
 public:
  explicit SkyWatch(const Installation& installation, ObservationPlan options = {});

  // For a recorded frame, whose own time is used and trusted. Errors (bad_input): a frame without a picture: truncated,
  // flagged, damaged, of another size. The watch can continue.
  Result<SkyReport> observe(const Frame& frame) {
    return observe(frame, frame.metadata.captured_at, SunSource::ephemeris);
  }
  // For a live frame that arrived at `when`. `sun_from`: where to take the sun's position from; with `none` nothing is
  // estimated.
  Result<SkyReport> observe(const Frame& frame, Instant when, SunSource sun_from);
  // The same for a frame that was read elsewhere, by a reader of this installation, and arrived at `when`.
  SkyReport observe(SkyReport read, Instant when);
  // What the scene camera shows of the air: it drives the picture where the sky does not show it, too.
  void observe(const TrackerReading& scene);
  // An earlier report with the air as it is known now.
  SkyReport with_air(SkyReport report, Instant when) const;
  // While no frame comes: the last estimate, the tracked air at its present age, the sun's position at `utc`.
  SkyReport at(Instant when, Utc utc, SunSource sun_from) const;
  // What of the air is worth keeping over a restart; empty while nobody has seen it, and where it is given.
  std::optional<RememberedAir> to_remember(Instant when, Utc utc) const;
  // Restores what was known at an earlier instant: the state, or the sky camera's T. No effect once it was seen again.
  void remember(const RememberedAir& air, Instant when) { air_.remember(air, when); }
  void remember(Turbidity turbidity, double sigma, Instant when);

 private:
  FoundAerosol found_in(const TurbidityEstimate& estimate) const;
  FoundAerosol of_site(FoundAerosol found) const;
  void add_air(SkyReport& report, Instant when) const;

  FrameReader reader_;
  GivenAir given_;
  AirTracker air_;
  // Of the scene camera. What is learnt while visitors look comes in over minutes; what was known at a start, at once.
  struct Saturation {
    double before = 1.0, learnt = 1.0;
    Instant learnt_at{};
    double at(Instant when) const;
  };
  std::optional<Saturation> scene_saturation_;
  bool scene_seen_ = false;
  TurbidityEstimate last_estimate_;
  std::shared_ptr<const MeasuredSky> last_measured_;  // of the same frame
  Instant last_observed_{};
};

// Marks an estimate with impossible numbers as unusable, with a reason.
TurbidityEstimate checked(TurbidityEstimate estimate);

}  // namespace kasumi
