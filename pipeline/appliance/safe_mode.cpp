#include "pipeline/appliance/safe_mode.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "pipeline/config/messages.hpp"
#include "pipeline/loop/loop_guard.hpp"
#include "pipeline/start/safe_content.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kRedrawInterval = 1s;  // it proves that the screen still takes pictures
constexpr Duration kSafeBufferDeadline = 250ms;
constexpr Duration kSafeStuckDisplay = 1500ms;  // no flip completes: reopen the display
constexpr Duration kOpenInterval = 1s;
constexpr Duration kSafeStatusInterval = 1s;
constexpr Duration kSafeProof = 10min;
constexpr Duration kLongestSleep = 200ms;

}  // namespace

SafeMode::SafeMode(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, StartLog& starts,
                   std::optional<std::filesystem::path> status_file)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      notifier_(notifier),
      starts_(starts),
      status_file_(std::move(status_file)),
      watchdog_(notifier),
      began_(clock.now()),
      lasts_(from_seconds(safe_for_s(starts.record()))),
      try_at_(clock.now()),
      server_(
          status_file_ ? std::optional(status_file_->parent_path()) : std::nullopt,
          [this](SnapshotKind kind) { wanted_.put(kind); }, answers_, clock) {
  desk_.allow_pages(content_->config.snapshot.screen_picture);
  status_.since = clock.utc();
  status_.start = starts.record();
  status_.render.rung = {Shown::still, Trouble::safe_mode, 1.0, 0.0};
  for (const auto* camera : {"scene camera", "sky camera"}) spdlog::info("{}: left alone in safe mode", camera);
  status_.scene_camera.health.cause = status_.sky_camera.health.cause = "safe mode: not opened";
}

void SafeMode::try_open() {
  const auto now = clock_.now();
  if (now < try_at_) return;
  try_at_ = now + kOpenInterval;
  auto& told = status_.render.display;
  auto display = devices_.open_display(content_->config.display);
  auto still =
      display ? StillPicture::create((*display)->context(), *content_) : Result<StillPicture>(fail(display.error()));
  if (!still) {
    if (!display && display.error().kind == FaultKind::disconnected) watchdog_.display_missing(now);
    if (told.cause != still.error().message) spdlog::warn("display: not available: {}", still.error().message);
    told.up = false;
    told.cause = still.error().message;
    return;
  }
  told.up = true;
  told.cause.clear();
  told.description = (*display)->description();
  spdlog::info("display: {}", told.description);
  open_.emplace(Open{std::move(*display), std::move(*still), {}, {}});
  shown_at_.reset();
  timeouts_since_.reset();
}

// Errors: those of Display::begin() and show(), but a timeout only when it persists.
Result<> SafeMode::show() {
  const auto target = open_->display->begin(clock_.now() + kSafeBufferDeadline);
  if (!target && target.error().kind == FaultKind::timeout) {
    const auto now = clock_.now();
    ++status_.render.display.flip_timeouts;
    if (!timeouts_since_) timeouts_since_ = now - kSafeBufferDeadline;
    if (now - *timeouts_since_ < kSafeStuckDisplay) return {};
  }
  if (!target) return fail(target.error());
  timeouts_since_.reset();

  auto& context = open_->display->context();
  const auto& config = content_->config;
  const auto& font = config.messages.font_file;
  auto message = this->message();
  clear_to(*target, glm::vec3(kStillBackground) / 255.0f);
  if (auto drawn = open_->still.draw(*target, {}, 1.0); !drawn) return drawn;
  if (auto drawn = open_->caption.draw(context, config.still.caption, font, false, 1.0, *target); !drawn) return drawn;
  if (auto drawn = open_->message.draw(context, message, font, true, 1.0, *target); !drawn) return drawn;
  if (desk_.is_due(clock_.now()))
    if (auto taken = desk_.take(snapshot_facts(), *target, clock_.now()); !taken) return taken;
  if (auto number = open_->display->show(); !number) return fail(number.error());
  ++status_.render.pictures;
  shown_at_ = clock_.now();
  shown_message_ = std::move(message);
  desk_.told(*shown_at_);
  return {};
}

std::string SafeMode::message() const {
  const auto& options = content_->config.messages;
  if (auto told = desk_.words(clock_.now()); !told.empty()) return told;
  return std::string(options.show_faults ? message_text(Message::safe_mode, options.language) : "");
}

// All but the picture itself.
Snapshot SafeMode::snapshot_facts() const {
  Snapshot facts;
  facts.shown = open_ ? name_of(Shown::still) : "nothing";
  facts.reason = open_ ? std::string(name_of(Trouble::safe_mode)) : "no display: " + status_.render.display.cause;
  facts.utc = clock_.utc();
  if (!open_) return facts;
  for (const auto& text : {content_->config.still.caption, message()})
    if (!text.empty()) facts.words += (facts.words.empty() ? "" : " / ") + text;
  return facts;
}

void SafeMode::prove() {
  if (proven_ || clock_.now() - began_ < kSafeProof) return;
  proven_ = true;
  starts_.well();
}

void SafeMode::write_status() {
  status_.now = clock_.now();
  status_.utc = clock_.utc();
  status_.render.page_pictures = desk_.page_pictures();
  if (status_at_ && status_.now - *status_at_ < kSafeStatusInterval) return;
  if (!status_at_) notifier_.status(status_line(status_));
  status_at_ = status_.now;
  if (status_file_) (void)write_text_file(*status_file_, status_json(status_));
}

Instant SafeMode::step() {
  if (!open_) try_open();
  if (const auto kind = wanted_.take()) desk_.request(*kind, content_->config, clock_.now());
  if (!open_) desk_.give_none(snapshot_facts());
  if (open_) {
    const bool due = !shown_at_ || clock_.now() - *shown_at_ >= kRedrawInterval || message() != shown_message_ ||
                     desk_.is_due(clock_.now());
    if (auto shown = due ? show() : Result<>(); !shown) {
      spdlog::warn("display: lost: {}", shown.error().message);
      ++status_.render.display.resets;
      status_.render.display.up = false;
      status_.render.display.cause = shown.error().message;
      open_.reset();
    }
  }
  if (open_)
    for (const auto& flip : open_->display->take_flips()) {
      if (++status_.render.display.flips == 1) starts_.shown();
      watchdog_.picture_shown(std::max(flip.at, clock_.now()));
    }
  prove();
  write_status();
  return clock_.now() + (open_ ? kRedrawInterval / 10 : kOpenInterval / 4);
}

void SafeMode::finish() {
  open_.reset();
  status_at_.reset();
  write_status();
}

Result<> run_safe_mode(const std::filesystem::path& config_file, StartLog& starts,
                       std::optional<std::filesystem::path> status_file) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);  // what a driver kept may be what it stumbles over

  const auto record = starts.record();
  spdlog::error("safe mode: only the still picture is shown, since {} boots in a row came to nothing:",
                record.failed_boots);
  for (const auto& why : record.why) spdlog::error("  {}", why);
  spdlog::error("everything is tried again after {:.0f} h, or at once by: sudo systemctl restart kasumi",
                safe_for_s(record) / 3600.0);

  SystemClock clock;
  const auto devices = machine_devices(clock);
  const auto notifier = notify_systemd();
  SafeMode mode(read_safe_content(config_file, record.mode), *devices, clock, *notifier, starts,
                std::move(status_file));
  starts.doing("showing the still picture in safe mode");
  std::atomic<bool> ending = false;
  std::thread snapshots([&] {
    LoopGuard guard("snapshot", clock);
    while (!ending)
      if (!guard.run([&] { mode.snapshot().step(); }) && !ending) clock.sleep_until(guard.again_at());
  });
  for (bool wanted = true; wanted;) {
    const auto again = mode.step();
    const auto pause = std::clamp<Duration>(again - clock.now(), 1ms, kLongestSleep);
    const timespec timeout{0, static_cast<long>(pause.count())};
    const int signal = ::sigtimedwait(&signals, nullptr, &timeout);
    wanted = signal < 0 && !mode.is_over();
  }
  notifier->stopping();
  starts.ended();
  ending = true;
  clock.interrupt();
  mode.snapshot_bell().ring();
  snapshots.join();
  mode.finish();
  return {};
}

}  // namespace kasumi
