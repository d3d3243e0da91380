#include "pipeline/kiosk/appliance/safe_mode.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "base/outside/abandonable.hpp"
#include "base/outside/lines.hpp"
#include "pipeline/kiosk/loop/loop_guard.hpp"
#include "pipeline/site/config/messages.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kRedrawInterval = 1s;  // it proves that the screen still takes pictures
// Far longer than a flip: no buffer for so long is a stuck display.
constexpr Duration kSafeBufferDeadline = 250ms;
constexpr Duration kSafeStuckDisplay = 1500ms;  // no flip completes: reopen the display
// Between attempts to open a display: the picture is back within 3 s (docs/faults.md 15)
constexpr Duration kOpenInterval = 1s;
constexpr Duration kSafeStatusInterval = 1s;  // bounds how old the status is
constexpr Duration kSafeProof = 10min;        // as kProof of the proving loop
constexpr Duration kLongestSleep = 200ms;     // bounds how late a stop or a reload is noticed
// Doubles: content that lacks a disk is soon back, content that is broken stays broken.
constexpr Duration kFirstContentPause = 15s, kLongestContentPause = 5min;
constexpr Duration kTrialDeadline = 2min;  // to read it and try to draw it: then another try begins

}  // namespace

SafeMode::SafeMode(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, StartLog& starts,
                   std::optional<std::filesystem::path> status_file, SafeReason reason)
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
  status_.render.rung = {Shown::still, reason.trouble, 1.0, 0.0};
  const bool without_content = reason.trouble == Trouble::content_refused;
  if (without_content) status_.instead = InsteadOfConfigured{{}, std::move(reason.refused)};
  for (const auto* camera : {"scene camera", "sky camera"}) spdlog::info("{}: left alone", camera);
  status_.scene_camera.health.cause = status_.sky_camera.health.cause =
      without_content ? "no content: not opened" : "safe mode: not opened";
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
  auto message = this->message();
  clear_to(*target, glm::vec3(kStillBackground) / 255.0f);
  if (auto drawn = open_->still.draw(*target, {}, 1.0); !drawn) return drawn;
  if (auto drawn = open_->caption.draw(context, config.still.caption, config.messages, false, 1.0, *target); !drawn)
    return drawn;
  if (auto drawn = open_->message.draw(context, message, config.messages, true, 1.0, *target); !drawn) return drawn;
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
  facts.reason =
      open_ ? std::string(name_of(status_.render.rung.trouble)) : "no display: " + status_.render.display.cause;
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
  if (!status_file_) return;
  starts_.note_in_memory("status",
                         [file = *status_file_, text = status_json(status_)] { (void)write_text_file(file, text); });
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

void SafeMode::tried(Instant began, std::vector<std::string> problems) {
  status_.instead->refused = problems;
  status_.reload = {began, clock_.utc(), std::move(problems), {}, {}};
  status_at_.reset();
}

void SafeMode::finish(Trouble trouble) {
  open_.reset();
  status_.render.rung = {Shown::nothing, trouble, 1.0, 0.0};
  status_at_.reset();
  write_status();
}

namespace {

sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Steps it, answers snapshots, and hears the signals. `go_on` is called after each step, with the received signal (-1:
// none).
void run_until(SafeMode& mode, SystemClock& clock, const std::function<bool(int signal)>& go_on) {
  const auto signals = block_signals();
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
    wanted = go_on(::sigtimedwait(&signals, nullptr, &timeout));
  }
  ending = true;
  clock.interrupt();
  mode.snapshot_bell().ring();
  snapshots.join();
}

}  // namespace

Result<> run_safe_mode(const FindConfiguration& find, StartLog& starts,
                       std::optional<std::filesystem::path> status_file) {
  block_signals();
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
  SafeMode mode(read_safe_content(find, record.mode), *devices, clock, *notifier, starts, std::move(status_file));
  starts.doing("showing the still picture in safe mode");
  run_until(mode, clock, [&](int signal) {
    const bool wanted = signal < 0 && !mode.is_over();
    if (!wanted) notifier->stopping();
    if (!wanted) starts.ended();
    return wanted;
  });
  mode.finish();
  return {};
}

ContentPtr run_without_content(const FindConfiguration& find, StartLog& starts,
                               std::optional<std::filesystem::path> status_file, std::vector<std::string> refused,
                               const std::function<Result<ContentPtr>()>& try_again) {
  block_signals();
  spdlog::error("nothing can be shown but the still picture and words; everything is tried again every few minutes:");
  for (const auto& problem : refused) spdlog::error("  {}", problem);
  SystemClock clock;
  const auto devices = machine_devices(clock);
  const auto notifier = notify_systemd();
  SafeMode mode(read_safe_content(find, StartMode::safe), *devices, clock, *notifier, starts, std::move(status_file),
                {Trouble::content_refused, refused});
  starts.doing("showing the still picture, since no content is left that can be shown");
  ContentPtr found;
  std::optional<Abandonable<Result<ContentPtr>>> trying;
  Duration pause = kFirstContentPause;
  auto again_at = clock.now() + pause, abandon_at = clock.now(), began_at = clock.now();
  run_until(mode, clock, [&](int signal) {
    if (signal == SIGTERM || signal == SIGINT) {
      notifier->stopping();
      starts.ended();
      return false;
    }
    const auto now = clock.now();
    if (signal == SIGHUP) notifier->ready();  // ends its reload; the status shows the result
    if (signal == SIGHUP || (!trying && now >= again_at) || (trying && now >= abandon_at)) {
      trying.emplace(try_again);
      began_at = now;
      abandon_at = now + kTrialDeadline;
      pause = std::min(2 * pause, kLongestContentPause);
    }
    auto content = trying ? trying->take(Duration{}) : std::nullopt;
    if (!content) return true;
    trying.reset();
    again_at = now + pause;
    if (*content) found = std::move(**content);
    mode.tried(began_at, found ? std::vector<std::string>() : lines_of(content->error().message));
    return !found;
  });
  mode.finish(found ? Trouble::starting : Trouble::stopped);
  return found;
}

}  // namespace kasumi
