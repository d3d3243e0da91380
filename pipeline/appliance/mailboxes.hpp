// Everything that passes between the appliance's loops: a mailbox for each. Nothing else is shared.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "base/bell.hpp"
#include "base/latest_slot.hpp"
#include "capture/reconnecting_source.hpp"
#include "pipeline/config/content.hpp"
#include "pipeline/scene/scene_frame.hpp"
#include "pipeline/scene/sky_watch.hpp"

namespace kasumi {

// A camera's state as its loop knows it.
struct CameraStatus {
  CameraHealth health;
  std::uint64_t outages = 0;  // frames from before the last outage must be released
  Duration frame_interval{};  // 0: unknown
};

struct SkyStatus {
  SkyReport report;
  bool up = false;  // the sky camera delivers pictures
  bool clock_trusted = false;
  bool sun_known() const { return report.sun.source != SunSource::none; }
};

// A picture that the daily check or the landmarks requested from a camera's loop.
struct CheckPicture {
  FrameMetadata metadata;
  Image<Rgb8> picture;
  bool time_known = false;  // metadata.utc is reliable enough for the sun's position
};

// The air as the sky camera measures it, for comparison.
struct SkyAir {
  std::optional<TrackedTurbidity> turbidity;  // empty: unknown or not trustworthy
  std::optional<SunDirection> sun;
};

// A loop's mailbox: what the others have posted since it last read it.
struct Mailbox {
  LatestSlot<ContentPtr> content;  // to be used from now on
};

struct SceneMailbox : Mailbox {
  std::atomic<bool> check_wants_picture = false, visibility_wants_picture = false;  // the next that comes
};

struct SkyMailbox : Mailbox {
  std::atomic<bool> check_wants_picture = false;  // the next that comes
};

struct RenderMailbox : Mailbox {
  LatestSlot<SceneFrame> frames;
  LatestSlot<CameraStatus> scene_camera;
  LatestSlot<SkyStatus> sky;
  Bell bell;  // rung by whoever posts something that cannot wait
};

struct CheckMailbox : Mailbox {
  LatestSlot<CheckPicture> scene, sky;
  std::atomic<bool> clock_trusted = false;
};

struct VisibilityMailbox : Mailbox {
  LatestSlot<CheckPicture> scene;
  LatestSlot<SkyAir> sky;
};

struct StatusMailbox;  // in status_mailbox.hpp, since its contents would make everyone include everything

struct Mailboxes {
  Mailboxes();
  ~Mailboxes();
  // Of every loop.
  std::array<Mailbox*, 6> all();

  SceneMailbox scene;
  SkyMailbox sky;
  RenderMailbox render;
  CheckMailbox check;
  VisibilityMailbox visibility;
  const std::unique_ptr<StatusMailbox> status;
};

}  // namespace kasumi
