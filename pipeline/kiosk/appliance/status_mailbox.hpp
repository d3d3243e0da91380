// What the other loops report to the status loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/landmarks/channel_extinctions.hpp"
#include "estimator/passers/passers.hpp"
#include "pipeline/install/camera_drift/drift.hpp"
#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/kiosk/content/probation.hpp"
#include "pipeline/kiosk/loop/latency.hpp"
#include "pipeline/kiosk/loop/television_switch.hpp"
#include "pipeline/kiosk/start/remembered_layer.hpp"
#include "pipeline/kiosk/visitor/visitor_desk.hpp"
#include "pipeline/site/config/ladder.hpp"

namespace kasumi {

struct DisplayStatus {
  bool up = false;
  std::string description;
  std::string cause;  // why it is not up
  std::uint64_t flips = 0;
  std::uint64_t flip_timeouts = 0;
  std::uint64_t resets = 0;  // how often it was reopened
  std::string planes;        // "on": pictures go onto planes of its own; else why not
  std::string mixing;        // who mixes pictures and the building: "processor" or "gpu"; empty: not up yet
};

// Whether people before the building stay in front of it.
struct PassersStatus {
  PassersState state = PassersState::learning;
  double known_share = 0.0, covered_share = 0.0;  // of the building's surroundings
  Duration until_watching{};                      // at least, while learning
};

struct RenderStatus {
  Rung rung;
  DisplayStatus display;
  bool building_drawn = false;                   // in the picture shown last
  std::optional<double> ground_known;            // share of the ground whose sunlight is known; empty: not looked at
  std::optional<CardsLook> cards;                // of known reflectance in view; empty: there are none
  std::uint64_t pictures = 0;                    // shown
  std::string draw_refused;                      // why the newest scene frames cannot be drawn; empty: they can
  std::uint64_t scene_frames = 0;                // of them, with a new frame from the scene camera
  std::uint64_t uploads = 0;                     // scene frames copied to the GPU by the CPU
  std::uint64_t camera_buffers_dropped = 0;      // how often the GPU gave the buffers of a camera back that was gone
  std::uint64_t frames_dropped = 0;              // superseded before they were shown
  std::optional<LatencySummary> latency;         // since the start
  std::optional<LatencySummary> latency_minute;  // of the last whole minute
  std::optional<PassersStatus> passers;          // empty: not asked for, or no picture yet
  PagePictures page_pictures;
  std::optional<VisitorStatus> visitor;  // empty: visitors choose nothing
  Instant told{};
};

// The reload under way, or the last one.
struct ReloadStatus {
  std::optional<Instant> began;       // the last one that ended
  std::optional<Utc> ended;           // empty: none has ended yet
  std::vector<std::string> problems;  // of the last one that ended; empty: its content is in use
  std::string doing;                  // what the one under way does now; empty: none is
  std::string era_problem;            // why the era whose time has come is not shown; empty: it is
};

// Result of the last check of the calibration.
struct CheckStatus {
  Utc at{};
  std::string summary;                // one line; also when there was nothing to compare
  std::optional<DriftReport> report;  // empty: no comparison was made
};

// The air as the landmarks in the scene camera's picture show it.
struct VisibilityStatus {
  Utc at{};
  std::optional<ChannelExtinctions> air;    // empty: not measured, and `reason` says why
  std::optional<ExtinctionComparison> sky;  // empty: no turbidity from the sky to compare with
  std::string reason;
  bool finding = false;  // they have disagreed with the sky for minutes
};

struct StatusMailbox : Mailbox {
  StatusMailbox() : Mailbox("status") {}
  LatestSlot<CameraStatus> scene_camera, sky_camera;
  LatestSlot<SkyStatus> sky;
  LatestSlot<RenderStatus> render;
  LatestSlot<ReloadStatus> reload;
  LatestSlot<CheckStatus> check;
  LatestSlot<VisibilityStatus> visibility;
  LatestSlot<ProbationStatus> probation;
  LatestSlot<TelevisionStatus> television;
  LatestSlot<LayerState> layer;  // to be kept
};

}  // namespace kasumi
