#include "pipeline/lab/recording/record.hpp"

#include <atomic>
#include <mutex>
#include <thread>

#include <spdlog/spdlog.h>

#include "base/latest_slot.hpp"
#include "pipeline/lab/recording/record_screen.hpp"
#include "pipeline/site/config/messages.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFrameTimeout = 200ms;   // for a frame: then a camera's loop checks whether to stop
constexpr Duration kScreenInterval = 40ms;  // between checks for a picture to show
constexpr Duration kBufferTimeout = 250ms;  // for a free display buffer
constexpr Duration kDisplayInterval = 2s;   // between attempts to reopen the display

// Why the recording ended; the first reason counts.
class Ending {
 public:
  void set(std::string why, bool planned) {
    const std::lock_guard lock(mutex_);
    if (over_) return;
    why_ = std::move(why);
    planned_ = planned;
    over_ = true;
  }
  bool over() const { return over_; }
  std::string why() const { return why_; }  // only once over()
  bool planned() const { return planned_; }

 private:
  std::mutex mutex_;
  std::atomic<bool> over_ = false;
  std::string why_;
  bool planned_ = false;
};

// Frames wait for the disk: lending buffers would stall the driver.
CameraOptions without_lending(CameraOptions options) {
  std::visit(
      [](auto& chosen) {
        if constexpr (requires { chosen.request; }) chosen.request.lend_buffers = false;
      },
      options);
  return options;
}

// One camera's loop.
class CameraRecorder {
 public:
  CameraRecorder(CameraRole role, CameraOpening opening, Recording& recording, Clock& clock, Duration every)
      : role_(role), recording_(recording), clock_(clock), every_(every), due_(clock.now()) {
    source_ = reconnecting(std::move(opening), clock);
  }

  void run(Ending& ending, LatestSlot<Frame>& to_show) {
    while (!ending.over()) {
      auto frame = source_->next(clock_.now() + kFrameTimeout);
      Result<> kept;
      if (frame)
        kept = keep(*frame);
      else if (frame.error().kind == FaultKind::disconnected)
        kept = record_outage(frame.error().message);
      else if (frame.error().kind == FaultKind::end_of_stream)
        ending.set(frame.error().message, true);
      if (!kept) return ending.set(kept.error().message, kept.error().kind == FaultKind::end_of_stream);
      if (frame) to_show.put(std::move(*frame));
    }
  }

  CameraHealth health() const { return source_->health(); }

 private:
  Result<> keep(const Frame& frame) {
    if (clock_.now() < due_) return {};
    if (every_ > Duration{0}) due_ = std::max(due_ + every_, clock_.now());
    auto kept = recording_.keep(role_, frame);
    if (kept || kept.error().kind != FaultKind::bad_input) return kept;
    spdlog::warn("{}: frame dropped: {}", name(), kept.error().message);
    return {};
  }
  Result<> record_outage(const std::string& cause) {
    spdlog::warn("{}", cause.starts_with(name()) ? cause : fmt::format("{}: {}", name(), cause));
    return recording_.keep_disconnect(role_, clock_.now(), clock_.utc());
  }
  const char* name() const { return role_ == CameraRole::sky ? "sky camera" : "scene camera"; }

  CameraRole role_;
  Recording& recording_;
  Clock& clock_;
  Duration every_;
  Instant due_;
  std::unique_ptr<ReconnectingSource> source_;
};

std::string caption_text(const std::string& word, Duration lasted, std::uint64_t bytes) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(lasted).count();
  return fmt::format("{}\n{:02}:{:02}   {:.0f} MB", word, seconds / 60, seconds % 60, static_cast<double>(bytes) / 1e6);
}

Result<RecordScreen> open_screen(Devices& devices, const RunConfig& config) {
  auto display = devices.open_display(config.display);
  if (!display) return fail(display.error());
  return RecordScreen::open(std::move(*display), config);
}

// The display's loop, in the calling thread.
void run_screen(RecordScreen first, const RecordRequest& request, const RunConfig& config, Devices& devices,
                const Recording& recording, Clock& clock, const std::function<bool()>& stop, Ending& ending,
                LatestSlot<Frame>& frames) {
  const std::string word(message_text(Message::recording, config.messages.language));
  std::optional<RecordScreen> screen = std::move(first);
  const auto began = clock.now();
  auto try_again_at = began;
  std::string shown;
  while (!ending.over()) {
    const auto now = clock.now();
    if (stop()) ending.set("interrupted", true);
    if (request.length > Duration{0} && now - began >= request.length)
      ending.set(fmt::format("{:.0f} s recorded", to_seconds(now - began)), true);
    if (!screen && now >= try_again_at) {
      if (auto opened = open_screen(devices, config)) screen = std::move(*opened);
      try_again_at = now + kDisplayInterval;
      shown.clear();
    }
    const auto frame = frames.take();
    const auto text = caption_text(word, now - began, recording.bytes());
    if (screen && (frame || text != shown)) {
      if (auto done = screen->show(frame ? &*frame : nullptr, text, now + kBufferTimeout); done) {
        shown = text;
      } else if (done.error().kind == FaultKind::end_of_stream) {
        ending.set("the window was closed", true);
      } else {
        spdlog::warn("display: lost: {}", done.error().message);
        screen.reset();
      }
    }
    clock.sleep_until(now + kScreenInterval);
  }
}

}  // namespace

Result<RecordSummary> record(const RecordRequest& request, Devices& devices, Clock& clock,
                             const std::function<bool()>& stop) {
  const auto root = ConfigTable::read_file(request.config);
  if (!root) return fail(root.error());
  const auto config = read_run_config(*root);
  if (auto whole = root->finish(); !whole) return fail(whole.error());

  auto screen = open_screen(devices, config);
  if (!screen)
    return fail(screen.error().kind,
                "{}\n(recording needs a display to show the notice; [display] kind = \"headless\" goes without)",
                screen.error().message);
  auto recording = Recording::create(request.config, request.folder, clock.utc(), request.limits);
  if (!recording) return fail(recording.error());

  const auto began = clock.now();
  CameraRecorder sky(CameraRole::sky, devices.camera(CameraRole::sky, without_lending(config.sky_camera)), **recording,
                     clock, request.every);
  CameraRecorder scene(CameraRole::scene, devices.camera(CameraRole::scene, without_lending(config.scene_camera)),
                       **recording, clock, request.every);
  Ending ending;
  LatestSlot<Frame> sky_frames, scene_frames;
  std::thread sky_thread([&] { sky.run(ending, sky_frames); });
  std::thread scene_thread([&] { scene.run(ending, scene_frames); });
  run_screen(std::move(*screen), request, config, devices, **recording, clock, stop, ending, scene_frames);
  sky_thread.join();
  scene_thread.join();

  RecordSummary summary;
  summary.sky = {(*recording)->rows(CameraRole::sky), sky.health()};
  summary.scene = {(*recording)->rows(CameraRole::scene), scene.health()};
  summary.bytes = (*recording)->bytes();
  summary.lasted = clock.now() - began;
  summary.ended = ending.why();
  summary.whole = ending.planned() && summary.sky.health.good_frames > 0 && summary.scene.health.good_frames > 0;
  return summary;
}

}  // namespace kasumi
