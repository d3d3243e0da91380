// What the loops tell the status of themselves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/landmarks/landmark_air.hpp"
#include "pipeline/appliance/latency.hpp"
#include "pipeline/appliance/mailboxes.hpp"
#include "pipeline/camera_drift/drift.hpp"
#include "pipeline/config/ladder.hpp"

namespace kasumi {

struct DisplayStatus {
  bool up = false;
  std::string description;
  std::string cause;  // why it is not up
  std::uint64_t flips = 0;
  std::uint64_t flip_timeouts = 0;
  std::uint64_t resets = 0;  // how often it was opened anew
};

struct RenderStatus {
  Rung rung;
  DisplayStatus display;
  bool building_drawn = false;                   // in the picture shown last
  std::uint64_t pictures = 0;                    // shown
  std::uint64_t scene_frames = 0;                // of them, with a new frame of the scene camera
  std::uint64_t uploads = 0;                     // scene frames copied to the GPU by us
  std::uint64_t frames_dropped = 0;              // a newer one came before they were shown
  std::optional<LatencySummary> latency;         // since the start
  std::optional<LatencySummary> latency_minute;  // of the last whole minute
};

// How the last attempt to take in new content ended.
struct ReloadStatus {
  Utc at{};
  std::vector<std::string> problems;  // empty: taken in
};

// How the last check of the calibration ended.
struct CheckStatus {
  Utc at{};
  std::string summary;                // in a line; also when there was nothing to compare
  std::optional<DriftReport> report;  // empty: no comparison was made
};

// What the landmarks in the scene camera's picture say of the air.
struct VisibilityStatus {
  Utc at{};
  std::optional<LandmarkAir> air;    // empty: not looked at, and `reason` says why
  std::optional<SkyComparison> sky;  // empty: the sky says nothing
  std::string reason;
  bool finding = false;  // they disagree with the sky, and have for minutes
};

struct StatusMailbox : Mailbox {
  LatestSlot<CameraStatus> scene_camera, sky_camera;
  LatestSlot<SkyStatus> sky;
  LatestSlot<RenderStatus> render;
  LatestSlot<ReloadStatus> reload;
  LatestSlot<CheckStatus> check;
  LatestSlot<VisibilityStatus> visibility;
};

}  // namespace kasumi
