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

// A camera as its loop knows it.
struct CameraStatus {
  CameraHealth health;
  std::uint64_t outages = 0;  // a frame of an earlier number is to be let go of
  Duration frame_interval{};  // 0: not known
};

struct SkyStatus {
  SkyReport report;
  bool up = false;  // the sky camera's pictures come
  bool clock_trusted = false;
  bool sun_known() const { return report.sun.source != SunSource::none; }
};

// A picture for the daily check, of a camera that was asked for one.
struct CheckPicture {
  FrameMetadata metadata;
  Image<Rgb8> picture;
  bool time_known = false;  // metadata.utc tells where the sun stands
};

// Today's air by the sky, for comparison.
struct SkyAir {
  std::optional<TrackedTurbidity> turbidity;  // empty: not known, or not trustworthy
  std::optional<SunDirection> sun;
};

// A loop's mailbox: what the others have put there since it looked.
struct Mailbox {
  LatestSlot<ContentPtr> content;  // to go by from now on
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
  Bell bell;  // rung by whoever puts what cannot wait
};

struct CheckMailbox : Mailbox {
  LatestSlot<CheckPicture> scene, sky;
  std::atomic<bool> clock_trusted = false;
};

struct VisibilityMailbox : Mailbox {
  LatestSlot<CheckPicture> scene;
  LatestSlot<SkyAir> sky;
};

struct StatusMailbox;  // status_mailbox.hpp: it hears of everything, which not everybody needs to know

struct Mailboxes {
  Mailboxes();
  ~Mailboxes();
  // Every loop's.
  std::array<Mailbox*, 6> all();

  SceneMailbox scene;
  SkyMailbox sky;
  RenderMailbox render;
  CheckMailbox check;
  VisibilityMailbox visibility;
  const std::unique_ptr<StatusMailbox> status;
};

}  // namespace kasumi
