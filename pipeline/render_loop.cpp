#include "pipeline/render_loop.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/words.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kBufferDeadline = 250ms;
constexpr Duration kStuckDisplay = 1500ms;  // no flip completes: the display is opened anew
constexpr Duration kDisplayInterval = 1s;   // between tries to open one
constexpr Duration kDisplayPause = 250ms;   // the same when displays are said to come and go
constexpr Duration kGlance = 100ms;         // how often what costs nothing is looked at
constexpr Duration kShowAgain = 1s;         // a picture without news: the loop's sign of life
constexpr Duration kFadeStep = 33ms;
constexpr Duration kTellInterval = 500ms;

std::optional<Trouble> trouble_of(PictureCondition condition) {
  switch (condition) {
    case PictureCondition::normal: return std::nullopt;
    case PictureCondition::frozen: return Trouble::scene_frozen;
    case PictureCondition::covered: return Trouble::scene_covered;
    case PictureCondition::white_out: return Trouble::scene_white_out;
  }
  return std::nullopt;
}

std::optional<Message> message_of(Trouble trouble) {
  switch (trouble) {
    case Trouble::none: return std::nullopt;
    case Trouble::starting: return Message::starting;
    case Trouble::scene_lost: return Message::scene_camera_missing;
    case Trouble::scene_frozen: return Message::scene_camera_frozen;
    case Trouble::scene_covered: return Message::scene_camera_covered;
    case Trouble::scene_white_out: return Message::scene_camera_blinded;
    case Trouble::sky_lost: return Message::sky_camera_missing;
    case Trouble::time_unknown: return Message::no_clock;
    case Trouble::closed: return Message::closed;
  }
  return std::nullopt;
}

bool is_fading(const Rung& rung) {
  const auto between = [](double opacity) { return opacity > 0.0 && opacity < 1.0; };
  return between(rung.still) || between(rung.dark);
}

}  // namespace

RenderLoop::RenderLoop(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, Exchange& exchange)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      exchange_(exchange),
      watch_(devices.watch_displays()),
      watchdog_(notifier),
      ladder_(content_->config.ladder),
      try_display_at_(clock.now()),
      tried_display_at_(clock.now() - kDisplayPause),
      shown_at_(clock.now()),
      minute_began_(clock.now()) {}

Instant RenderLoop::step() {
  take_news();
  take_content();
  if (!screen_) look_for_screen();
  climb();
  if (screen_) {
    note_flips();
    if (!rest() && is_due(clock_.now())) present();
    note_flips();
  } else {
    let_go_of_frames();
  }
  tell();
  const auto now = clock_.now();
  if (!screen_) return watch_ ? std::min(try_display_at_, now + kGlance) : try_display_at_;
  if (screen_->off) return now + kGlance;
  return is_fading(news_.rung) ? now + kFadeStep : std::min(shown_at_ + kShowAgain, now + kGlance);
}

void RenderLoop::take_content() {
  if (auto content = exchange_.render.content.take()) new_content_ = std::move(*content);
  // Its stage has no scene yet: the old one's stays on the glass until there is a frame to draw, or the still covers
  // it.
  const bool is_seen = screen_ && news_.rung.still < 1.0 && !is_closed();
  if (!new_content_ || (is_seen && !waiting_)) return;
  const auto content = std::exchange(new_content_, nullptr);
  const bool other_display = content->config.display != content_->config.display;
  if (screen_ && !other_display) {
    auto stage = Stage::create(screen_->display->context(), content);
    if (!stage) {
      spdlog::error("the new content cannot be drawn, the old one stays: {}", stage.error().message);
      return;
    }
    screen_->stage = std::move(*stage);
  }
  content_ = content;
  air_.reset();
  ladder_.adopt(patient_with(content_->config.ladder, camera_.frame_interval));
  shown_.reset();
  if (other_display) {
    screen_.reset();
    try_display_at_ = clock_.now();
  }
}

void RenderLoop::take_news() {
  if (auto sky = exchange_.render.sky.take()) sky_ = std::move(*sky);
  if (auto camera = exchange_.render.scene_camera.take()) {
    if (camera->outages != camera_.outages) shown_.reset();  // shown anew at once, so that the driver's buffer is free
    if (camera->frame_interval != camera_.frame_interval)
      ladder_.adopt(patient_with(content_->config.ladder, camera->frame_interval));
    camera_ = std::move(*camera);
  }
  if (auto frame = exchange_.render.frames.take()) waiting_ = std::move(*frame);
  if (waiting_ && waiting_->outages < camera_.outages) waiting_.reset();
}

void RenderLoop::let_go_of_frames() {
  if (waiting_) picture_at_ = clock_.now();  // there would be a picture if there were a display
  waiting_.reset();
}

Signs RenderLoop::signs() const {
  Signs signs;
  if (picture_at_) signs.picture_age = clock_.now() - *picture_at_;
  signs.bad_scene_picture = trouble_of(camera_.health.condition);
  signs.sky_up = sky_.up;
  signs.sun_known = sky_.sun_known();
  signs.open = is_open();
  return signs;
}

// A clock that is not believed closes no doors.
bool RenderLoop::is_open() const {
  return !sky_.clock_trusted || content_->config.opening.is_open(clock_.utc());
}

void RenderLoop::climb() {
  const auto before = news_.rung;
  news_.rung = ladder_.step(clock_.now(), signs());
  if (news_.rung.shown == before.shown && news_.rung.trouble == before.trouble) return;
  if (news_.rung.shown == Shown::held || before.shown == Shown::held) return;  // short, and the camera's log says why
  const auto why = name_of(news_.rung.trouble);
  spdlog::info("shown: {}{}{}", name_of(news_.rung.shown), why.empty() ? "" : ": ", why);
}

Composition RenderLoop::composition() const {
  return {news_.rung, words_now()};
}

// A sky camera that is gone is no visitor's concern while the air is still known.
std::string RenderLoop::words_now() const {
  const auto& choice = content_->config.words;
  const auto trouble = news_.rung.trouble;
  const auto message = message_of(trouble);
  const bool air_known = sky_.report.tracked && sky_.report.tracked->trustworthy;
  if (!choice.show_faults || !message || (trouble == Trouble::sky_lost && air_known)) return {};
  return std::string(words(*message, choice.language));
}

bool RenderLoop::is_due(Instant now) const {
  return waiting_ || !shown_ || *shown_ != composition() || now - shown_at_ >= kShowAgain;
}

void RenderLoop::look_for_screen() {
  if (watch_ && watch_->take_change()) try_display_at_ = std::min(try_display_at_, tried_display_at_ + kDisplayPause);
  if (clock_.now() >= try_display_at_) open_screen();
}

void RenderLoop::open_screen() {
  const auto now = clock_.now();
  tried_display_at_ = now;
  try_display_at_ = now + kDisplayInterval;
  auto display = devices_.open_display(content_->config.display);
  auto stage = display ? Stage::create((*display)->context(), content_, std::exchange(air_, std::nullopt))
                       : tl::unexpected(display.error());
  if (!stage) {
    news_.display.up = false;
    news_.display.cause = stage.error().message;
    if (!display && display.error().kind == FaultKind::disconnected) watchdog_.looked_for_display(now);
    if (!display_wanted_) spdlog::warn("display: not there: {}", stage.error().message);
    display_wanted_ = true;
    return;
  }
  display_wanted_ = false;
  spdlog::info("display: {}, {}", (*display)->description(), (*display)->context().info().renderer);
  for (const auto& note : stage->notes()) spdlog::info("display: {}", note);
  news_.display.up = true;
  news_.display.description = (*display)->description();
  news_.display.cause.clear();
  screen_ = Screen{std::move(*display), std::move(*stage)};
  shown_.reset();
  picture_at_.reset();  // the new stage has none
  timeouts_since_.reset();
}

void RenderLoop::lose_screen(const Fault& fault) {
  if (fault.kind == FaultKind::end_of_stream) {
    closed_ = true;
    return;
  }
  spdlog::warn("display: lost: {}", fault.message);
  ++news_.display.resets;
  news_.display.up = news_.building_drawn = false;
  news_.display.cause = fault.message;
  display_wanted_ = true;  // said
  latency_.forget_pending();
  air_ = screen_->stage.air();
  screen_.reset();
  try_display_at_ = clock_.now();
}

void RenderLoop::endure_timeout(const Fault& fault) {
  ++news_.display.flip_timeouts;
  const auto now = clock_.now();
  if (!timeouts_since_) timeouts_since_ = now - kBufferDeadline;
  if (now - *timeouts_since_ >= kStuckDisplay) lose_screen(fault);
}

// Closed: a last black picture, then the screen goes off where it can, and nothing is drawn any more. true: it is off.
bool RenderLoop::rest() {
  auto& screen = *screen_;
  if (!is_closed()) {
    screen.off = screen.stays_on = false;
    return false;
  }
  waiting_.reset();
  picture_at_.reset();  // in the morning nobody shall see yesterday's
  if (!screen.off && !screen.stays_on && shown_ && shown_->rung.dark >= 1.0) {
    const auto off = screen.display->turn_off();
    screen.off = off.has_value();
    screen.stays_on = !off && off.error().kind == FaultKind::unsupported;
    if (!off && !screen.stays_on && off.error().kind != FaultKind::timeout) {
      lose_screen(off.error());
      return true;
    }
  }
  if (screen.off) watchdog_.rests(clock_.now());
  return screen.off;
}

void RenderLoop::present() {
  auto& display = *screen_->display;
  const auto target = display.begin(clock_.now() + kBufferDeadline);
  if (!target)
    return target.error().kind == FaultKind::timeout ? endure_timeout(target.error()) : lose_screen(target.error());
  timeouts_since_.reset();

  take_news();  // the newest frame there is now
  // The still goes first: the scene's programs may take a driver long to make, and nobody shall see black meanwhile.
  const bool unseen = screen_->dark || is_closed();
  const auto frame = unseen ? std::nullopt : std::exchange(waiting_, std::nullopt);
  if (auto drawn = draw(frame ? &*frame : nullptr, *target); !drawn) return lose_screen(drawn.error());
  if (auto alive = display.context().check_alive(); !alive) return lose_screen(alive.error());
  const auto number = display.show(frame ? frame->holder : nullptr);
  if (!number) return lose_screen(number.error());

  screen_->dark = false;
  news_.building_drawn = screen_->stage.draws_object() && news_.rung.still < 1.0 && news_.rung.dark < 1.0;
  ++news_.pictures;
  shown_at_ = clock_.now();
  if (!frame) return;
  ++news_.scene_frames;
  latency_.shown(*number, frame->metadata.captured_at);
}

// Errors: device.
Result<> RenderLoop::draw(const SceneFrame* frame, const DrawTarget& target) {
  auto& stage = screen_->stage;
  const auto uploaded_before = stage.frames().uploaded;
  auto drawn = stage.draw_scene(frame, sky_.report, target);
  if (drawn && frame) picture_at_ = clock_.now();
  // A frame of the camera before new content came.
  if (!drawn && drawn.error().kind == FaultKind::bad_input) drawn = stage.draw_scene(nullptr, sky_.report, target);
  if (!drawn) return drawn;
  news_.uploads += stage.frames().uploaded - uploaded_before;
  climb();
  shown_ = composition();
  return stage.draw_over(*shown_, sky_.report, target);
}

void RenderLoop::note_flips() {
  if (!screen_) return;
  for (const auto& flip : screen_->display->take_flips()) {
    ++news_.display.flips;
    latency_.flipped(flip.number, flip.at);
    watchdog_.picture_shown(clock_.now());
  }
}

void RenderLoop::finish() {
  note_flips();
  waiting_.reset();
  screen_.reset();
  told_.reset();
  tell();
}

void RenderLoop::tell() {
  const auto now = clock_.now();
  if (told_ && now - *told_ < kTellInterval) return;
  told_ = now;
  news_.frames_dropped = exchange_.render.frames.dropped();
  news_.latency = latency_.whole();
  if (now - minute_began_ >= 1min) {
    minute_began_ = now;
    news_.latency_minute = latency_.take_minute();
  }
  exchange_.status->render.put(news_);
}

}  // namespace kasumi
