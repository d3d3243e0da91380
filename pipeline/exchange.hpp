// Everything that passes between the appliance's loops. Nothing else is shared.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "base/bell.hpp"
#include "base/latest_slot.hpp"
#include "capture/reconnecting_source.hpp"
#include "estimator/landmark_air.hpp"
#include "pipeline/content.hpp"
#include "pipeline/drift.hpp"
#include "pipeline/ladder.hpp"
#include "pipeline/latency.hpp"
#include "pipeline/sky_watch.hpp"

namespace kasumi {

// A camera as its loop knows it.
struct CameraNews {
  CameraHealth health;
  std::uint64_t outages = 0;  // a frame of an earlier number is to be let go of
  Duration frame_interval{};  // 0: not known
};

struct SceneFrame {
  FrameMetadata metadata;
  DecodedPicture picture;
  std::shared_ptr<const void> holder;  // of the driver's buffer
  std::uint64_t outages = 0;
};

struct SkyNews {
  SkyReport report;
  bool up = false;  // the sky camera's pictures come
  bool clock_trusted = false;
  bool sun_known() const { return report.sun.source != SunSource::none; }
};

struct DisplayNews {
  bool up = false;
  std::string description;
  std::string cause;  // why it is not up
  std::uint64_t flips = 0;
  std::uint64_t flip_timeouts = 0;
  std::uint64_t resets = 0;  // how often it was opened anew
};

struct RenderNews {
  Rung rung;
  DisplayNews display;
  bool building_drawn = false;                   // in the picture shown last
  std::uint64_t pictures = 0;                    // shown
  std::uint64_t scene_frames = 0;                // of them, with a new frame of the scene camera
  std::uint64_t uploads = 0;                     // scene frames copied to the GPU by us
  std::uint64_t frames_dropped = 0;              // a newer one came before they were shown
  std::optional<LatencySummary> latency;         // since the start
  std::optional<LatencySummary> latency_minute;  // of the last whole minute
};

// How the last attempt to take in new content ended.
struct ReloadNews {
  Utc at{};
  std::vector<std::string> problems;  // empty: taken in
};

// A picture for the daily check, of a camera that was asked for one.
struct CheckPicture {
  FrameMetadata metadata;
  Image<Rgb8> picture;
  bool time_known = false;  // metadata.utc tells where the sun stands
};

// How the last check of the calibration ended.
struct CheckNews {
  Utc at{};
  std::string summary;                // in a line; also when there was nothing to compare
  std::optional<DriftReport> report;  // empty: no comparison was made
};

// What the landmarks in the scene camera's picture say of the air.
struct VisibilityNews {
  Utc at{};
  std::optional<LandmarkAir> air;    // empty: not looked at, and `reason` says why
  std::optional<SkyComparison> sky;  // empty: the sky says nothing
  std::string reason;
  bool finding = false;  // they disagree with the sky, and have for minutes
};

// Today's air by the sky, for comparison.
struct SkyAir {
  std::optional<TrackedTurbidity> turbidity;  // empty: not known, or not trustworthy
  std::optional<SunDirection> sun;
};

struct Exchange {
  LatestSlot<SceneFrame> scene_frames;
  LatestSlot<CameraNews> scene_camera;
  LatestSlot<SkyNews> sky;

  struct ForStatus {
    LatestSlot<CameraNews> scene_camera, sky_camera;
    LatestSlot<SkyNews> sky;
    LatestSlot<RenderNews> render;
    LatestSlot<ReloadNews> reload;
    LatestSlot<CheckNews> check;
    LatestSlot<VisibilityNews> visibility;
  } status;

  struct ForCheck {
    std::atomic<bool> scene_wanted = false, sky_wanted = false;  // a picture, the next that comes
    std::atomic<bool> clock_trusted = false;
    LatestSlot<CheckPicture> scene, sky;
  } check;

  struct ForVisibility {
    std::atomic<bool> scene_wanted = false;  // a picture, the next that comes
    LatestSlot<CheckPicture> scene;
    LatestSlot<SkyAir> sky;
  } visibility;

  struct NewContent {
    LatestSlot<ContentPtr> scene, sky, render, status, check, visibility;
  } content;

  Bell render_bell;  // there is news for the render loop
};

}  // namespace kasumi
