// Everything that passes between the appliance's loops: a mailbox for each. Nothing else is shared. Reports carry their
// time, since the loop that made them may hang.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "base/bell.hpp"
#include "base/latest_slot.hpp"
#include "capture/reconnecting_source.hpp"
#include "pipeline/kiosk/loop/pulse.hpp"
#include "pipeline/kiosk/snapshot/snapshot.hpp"
#include "pipeline/show/scene/horizon_observer.hpp"
#include "pipeline/show/scene/layer_light.hpp"
#include "pipeline/show/scene/scene_frame.hpp"
#include "pipeline/show/scene/scene_watch.hpp"
#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

struct PreparedStage;

// A camera's state as its loop knows it.
struct CameraStatus {
  CameraHealth health;
  std::uint64_t outages = 0;  // frames from before the last outage must be released
  Duration frame_interval{};  // 0: unknown
  Instant told{};
};

struct SkyStatus {
  SkyReport report;
  bool up = false;  // the sky camera delivers pictures
  bool clock_trusted = false;
  std::optional<RememberedAir> to_remember;  // over a restart; its utc is the machine's
  Instant told{};                            // ages in the report are those of this instant
  bool sun_known() const { return report.sun.source != SunSource::none; }
};

// A picture that the daily check or the landmarks requested from a camera's loop.
struct RequestedFrame {
  FrameMetadata metadata;
  Image<Rgb8> picture;
  bool time_known = false;  // metadata.utc is reliable enough for the sun's position
};

// The air as the sky camera alone measures it, for comparison.
struct ObservedTurbidity {
  std::optional<Turbidity> turbidity;  // empty: unknown or too old
  double sigma = 0.0;                  // of it
  DaylightState above;
  Instant told{};
};

// A loop's mailbox: what the others have posted since it last read it, and its sign of life for them.
struct Mailbox {
  explicit Mailbox(std::string_view loop) : pulse(loop) {}
  LatestSlot<ContentPtr> content;  // to be used from now on
  Pulse pulse;
};

// New content, to be prepared on the display's GPU before any loop uses it. A later order replaces an earlier one.
struct StageOrder {
  std::uint64_t number = 0;
  ContentPtr content;  // null: never mind
  std::shared_ptr<const PreparedStage> prepared;
};
struct StageAnswer {
  enum class Kind {
    ready,       // it can be drawn, and is kept until the content arrives for use
    refused,     // and `problem` says why
    no_display,  // there is none to prepare it on
  };
  std::uint64_t number = 0;
  Kind kind = Kind::ready;
  std::string problem{};
};

struct SceneMailbox : Mailbox {
  SceneMailbox() : Mailbox("scene") {}
  std::atomic<bool> check_wants_picture = false, visibility_wants_picture = false;  // the next that comes
  std::atomic<int> show_one_of = 1;       // pictures, while the machine is too hot for all of them
  std::atomic<std::uint64_t> spared = 0;  // pictures not shown for that
};

struct SkyMailbox : Mailbox {
  SkyMailbox() : Mailbox("sky") {}
  std::atomic<bool> check_wants_picture = false;  // the next that comes
  LatestSlot<TrackerReading> scene_air;           // for the state of the air
};

struct RenderMailbox : Mailbox {
  RenderMailbox() : Mailbox("render") {}
  LatestSlot<SceneFrame> frames;
  LatestSlot<CameraStatus> scene_camera;
  LatestSlot<SkyStatus> sky;
  LatestSlot<StageOrder> order;
  LatestSlot<SnapshotKind> snapshot;  // wanted
  LatestSlot<HorizonAnswer> horizon;
  LatestSlot<LayerAnswer> layer;
  Bell bell;  // rung with messages that cannot wait
};

struct HorizonMailbox : Mailbox {
  HorizonMailbox() : Mailbox("horizon") {}
  LatestSlot<HorizonQuestion> question;
  LatestSlot<LayerQuestion> layer_question;
  Bell bell;
};

constexpr std::size_t kNoEra = std::numeric_limits<std::size_t>::max();  // none of those that there are

struct ReloadMailbox {
  Pulse pulse{"reload"};
  LatestSlot<StageAnswer> answer;
  std::atomic<std::size_t> era_further = 0;       // a visitor's choice: so many after the one of the day
  std::atomic<std::size_t> era_refused = kNoEra;  // the last that could not be shown, until it can
  Bell bell;
};

struct CheckMailbox : Mailbox {
  CheckMailbox() : Mailbox("check") {}
  LatestSlot<RequestedFrame> scene, sky;
  std::atomic<bool> clock_trusted = false;
};

struct VisibilityMailbox : Mailbox {
  VisibilityMailbox() : Mailbox("visibility") {}
  LatestSlot<RequestedFrame> scene;
  LatestSlot<ObservedTurbidity> sky;
};

struct TelevisionMailbox : Mailbox {
  TelevisionMailbox() : Mailbox("television") {}
  LatestSlot<bool> on;  // wanted from now on, or asleep
  Bell bell;
};

// The picture on the glass, for the snapshot server.
struct SnapshotMailbox {
  std::atomic<bool> for_page = false;  // kasumi-report may ask
  LatestSlot<Snapshot> taken;
  Bell bell;
};

// Signs of progress: counts that grow.
struct ProvingMailbox : Mailbox {
  ProvingMailbox() : Mailbox("proving") {}
  void see(std::uint64_t pictures, Duration interval, bool is_closed) {
    scene_pictures = pictures, scene_interval = interval, closed = is_closed;
  }
  std::atomic<std::uint64_t> alive = 0;           // the service manager was told so
  std::atomic<std::uint64_t> scene_pictures = 0;  // shown
  std::atomic<Duration> scene_interval{};         // of the scene camera; 0: unknown
  std::atomic<std::uint64_t> scene_frames = 0;    // whole, of the camera
  std::atomic<bool> closed = false;               // nothing is shown, on purpose
};

struct StatusMailbox;  // in status_mailbox.hpp, since its contents would make everyone include everything

struct Mailboxes {
  Mailboxes();
  ~Mailboxes();
  // Of every loop.
  std::array<Mailbox*, 9> all();
  std::array<const Mailbox*, 9> all() const;

  SceneMailbox scene;
  SkyMailbox sky;
  RenderMailbox render;
  HorizonMailbox horizon;
  CheckMailbox check;
  VisibilityMailbox visibility;
  TelevisionMailbox television;
  SnapshotMailbox snapshot;
  ProvingMailbox proving;
  ReloadMailbox reload;
  const std::unique_ptr<StatusMailbox> status;
};

}  // namespace kasumi
