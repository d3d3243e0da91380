#include "pipeline/appliance/render_loop.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/config/words.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kGlance = 100ms;  // how often what costs nothing is looked at
constexpr Duration kShowAgain = 1s;  // a picture without news: the loop's sign of life
constexpr Duration kFadeStep = 33ms;
constexpr Duration kTellScreenInterval = 500ms;

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
      clock_(clock),
      exchange_(exchange),
      watchdog_(notifier),
      ladder_(content_->config.ladder),
      screen_(content_, devices, clock, watchdog_, news_.display),
      shown_at_(clock.now()),
      minute_began_(clock.now()) {}

Instant RenderLoop::step() {
  take_news();
  take_content();
  if (!screen_.is_open() && screen_.look()) {
    shown_.reset();
    picture_at_.reset();  // the new stage has none
  }
  climb();
  if (screen_.is_open()) {
    note_flips();
    if (!rest() && is_due(clock_.now())) present();
    note_flips();
  } else {
    let_go_of_frames();
  }
  tell();
  const auto now = clock_.now();
  if (!screen_.is_open()) return screen_.next_look(now + kGlance);
  if (screen_.is_off()) return now + kGlance;
  return is_fading(news_.rung) ? now + kFadeStep : std::min(shown_at_ + kShowAgain, now + kGlance);
}

void RenderLoop::take_content() {
  if (auto content = exchange_.render.content.take()) new_content_ = std::move(*content);
  // Its stage has no scene yet: the old one's stays on the glass until there is a frame to draw, or the still covers
  // it.
  const bool is_seen = screen_.is_open() && news_.rung.still < 1.0 && !is_closed();
  if (!new_content_ || (is_seen && !waiting_)) return;
  const auto content = std::exchange(new_content_, nullptr);
  if (auto adopted = screen_.adopt(content); !adopted) {
    spdlog::error("the new content cannot be drawn, the old one stays: {}", adopted.error().message);
    return;
  }
  content_ = content;
  ladder_.adopt(patient_with(content_->config.ladder, camera_.frame_interval));
  shown_.reset();
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

void RenderLoop::lose_screen(const Fault& fault) {
  if (fault.kind == FaultKind::end_of_stream) {
    closed_ = true;
    return;
  }
  screen_.lose(fault);
  news_.building_drawn = false;
  latency_.forget_pending();
}

// Closed: a last black picture, then the screen goes off where it can, and nothing is drawn any more. true: it is off.
bool RenderLoop::rest() {
  if (!is_closed()) {
    screen_.stay_on();
    return false;
  }
  waiting_.reset();
  picture_at_.reset();  // in the morning nobody shall see yesterday's
  if (shown_ && shown_->rung.dark >= 1.0)
    if (auto off = screen_.turn_off(); !off) {
      lose_screen(off.error());
      return true;
    }
  if (screen_.is_off()) watchdog_.rests(clock_.now());
  return screen_.is_off();
}

void RenderLoop::present() {
  const auto target = screen_.begin();
  if (!target) return lose_screen(target.error());
  if (!*target) return;

  take_news();  // the newest frame there is now
  // The still goes first: the scene's programs may take a driver long to make, and nobody shall see black meanwhile.
  const bool unseen = screen_.nothing_shown() || is_closed();
  const auto frame = unseen ? std::nullopt : std::exchange(waiting_, std::nullopt);
  if (auto drawn = draw(frame ? &*frame : nullptr, **target); !drawn) return lose_screen(drawn.error());
  const auto number = screen_.show(frame ? frame->holder : nullptr);
  if (!number) return lose_screen(number.error());

  news_.building_drawn = screen_.stage().draws_object() && news_.rung.still < 1.0 && news_.rung.dark < 1.0;
  ++news_.pictures;
  shown_at_ = clock_.now();
  if (!frame) return;
  ++news_.scene_frames;
  latency_.shown(*number, frame->metadata.captured_at);
}

// Errors: device.
Result<> RenderLoop::draw(const SceneFrame* frame, const DrawTarget& target) {
  auto& stage = screen_.stage();
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
  if (!screen_.is_open()) return;
  for (const auto& flip : screen_.take_flips()) {
    latency_.flipped(flip.number, flip.at);
    watchdog_.picture_shown(clock_.now());
  }
}

void RenderLoop::finish() {
  note_flips();
  waiting_.reset();
  screen_.close();
  told_.reset();
  tell();
}

void RenderLoop::tell() {
  const auto now = clock_.now();
  if (told_ && now - *told_ < kTellScreenInterval) return;
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
