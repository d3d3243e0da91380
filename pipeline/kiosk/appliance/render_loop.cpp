#include "pipeline/kiosk/appliance/render_loop.hpp"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "pipeline/show/scene/aged_report.hpp"
#include "pipeline/site/config/messages.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kPollInterval = 100ms;   // for everything that is cheap to check
constexpr Duration kRefreshInterval = 1s;   // an unchanged picture is shown again: it proves that the loop is alive
constexpr Duration kContentMessage = 2min;  // that earlier content is shown
constexpr Duration kFadeStep = 33ms;
constexpr Duration kEraFade = 400ms;        // seen as a change, and over before one waits for it
constexpr Duration kVisitorStep = 20ms;     // a hand that wipes sees its wipe follow
constexpr Duration kLayerInterval = 10min;  // flash memory wears, and the layer is of a few megabytes
constexpr Duration kRenderStatusInterval = 500ms;
constexpr Duration kSkySilence = 2s;    // the sky's loop usually tells its news once a second
constexpr Duration kHangRestart = 60s;  // a camera's loop hangs for so long: restart
// For a coming stage, after each look for a picture: as long as the picture took, within these bounds. One that took
// seconds must not be followed by as many more.
constexpr Duration kPreparingTime = 10ms, kLongestPreparing = 250ms;
constexpr int kMostPreparingPieces = 16;  // the same by a clock that stands still

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
    case Trouble::safe_mode:
    case Trouble::content_refused: return Message::safe_mode;
    case Trouble::no_display:
    case Trouble::stopped: return std::nullopt;
  }
  return std::nullopt;
}

bool is_fading(const Rung& rung) {
  const auto between = [](double opacity) { return opacity > 0.0 && opacity < 1.0; };
  return between(rung.still) || between(rung.dark);
}

}  // namespace

RenderLoop::RenderLoop(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, Mailboxes& mailboxes)
    : content_(std::move(content)),
      clock_(clock),
      mailboxes_(mailboxes),
      watchdog_(notifier),
      ladder_(content_->config.ladder),
      screen_(content_, devices, clock, watchdog_, status_.display),
      recall_(content_, clock.utc()),
      layer_kept_at_(clock.now()),
      started_(clock.now()),
      snapshots_(mailboxes.snapshot),
      visitor_(devices, clock, [&mailboxes] { mailboxes.render.bell.ring(); }),
      shown_at_(clock.now()),
      minute_began_(clock.now()),
      hangs_({&mailboxes.scene.pulse, &mailboxes.sky.pulse, &mailboxes.check.pulse, &mailboxes.visibility.pulse,
              &mailboxes.proving.pulse, &mailboxes.horizon.pulse, &mailboxes.television.pulse, &mailboxes.status->pulse,
              &mailboxes.reload.pulse}) {
  snapshots_.allow_pages(content_->config.snapshot.screen_picture);
  visitor_.use(*content_);
}

// Nobody else can draw: whatever threw, the display is opened anew, and when that does not help the watchdog restarts.
Instant RenderLoop::step() try { return take_step(); } catch (const std::exception& thrown) {
  const auto why = fmt::format("drawing failed: {}", thrown.what());
  if (screen_.is_open())
    handle_screen_fault({FaultKind::device, why});
  else
    spdlog::error("display: {}", why);
  return screen_.next_attempt(clock_.now() + kPollInterval);
}

Instant RenderLoop::take_step() {
  turned_ = clock_.now();
  mailboxes_.render.pulse.turn(turned_, kPollInterval + kDrawingBound);
  watch_loops();
  read_mailbox();
  adopt_content();
  follow_visitor();
  if (!screen_.is_open() && screen_.try_open()) {
    shown_.reset();
    picture_at_.reset();  // the new stage has no scene picture
    if (auto before = recall_.take(content_)) screen_.stage().scene().layer().offer(std::move(*before));
  }
  update_rung();
  tell_television();
  if (!screen_.is_open() || is_closed()) snapshots_.give_none(snapshot_facts());
  if (screen_.is_open()) {
    record_flips();
    if (!turn_off_if_closed() && is_due(clock_.now())) present();
    record_flips();
  } else {
    discard_frames();
  }
  prepare_next_stage();
  publish();
  const auto now = clock_.now();
  if (next_.is_unfinished()) return now;
  if (!screen_.is_open()) return screen_.next_attempt(now + kPollInterval);
  if (screen_.is_off()) return now + kPollInterval;
  if (visitor_.is_moving()) return now + kVisitorStep;
  return is_fading(status_.rung) || (shown_ && shown_->before > 0.0)
             ? now + kFadeStep
             : std::min(shown_at_ + kRefreshInterval, now + kPollInterval);
}

// Whether a restart would help nobody knows, but nothing else is left to try.
void RenderLoop::watch_loops() {
  const auto now = clock_.now();
  hangs_.look(now);
  const auto for_long = [&](const Mailbox& camera) { return camera.pulse.hung(now).value_or(0s) >= kHangRestart; };
  watchdog_.withhold(for_long(mailboxes_.scene) || for_long(mailboxes_.sky));
}

void RenderLoop::take_content() {
  if (auto content = mailboxes_.render.content.take()) new_content_ = std::move(*content);
}

void RenderLoop::adopt_content() {
  take_content();
  // A new stage has no scene yet: the old picture stays on the display until there is a frame to draw or the still
  // picture covers it.
  const bool is_seen = screen_.is_open() && status_.rung.still < 1.0 && !is_closed();
  if (!new_content_ || (is_seen && !waiting_)) return;
  const auto content = std::exchange(new_content_, nullptr);
  auto before = is_seen ? what_fades_into(*content) : std::nullopt;
  if (auto adopted = screen_.adopt(content, next_.take(content)); !adopted) {
    spdlog::error("the new content cannot be drawn, keeping the old content: {}", adopted.error().message);
    return;
  }
  content_ = content;
  fading_since_.reset();
  if (before && screen_.is_open()) {
    screen_.stage().fade_from(std::move(*before));
    fading_since_ = clock_.now();
  }
  snapshots_.allow_pages(content_->config.snapshot.screen_picture);
  visitor_.use(*content_);
  ladder_.adopt(patient_with(content_->config.ladder, camera_.frame_interval));
  shown_.reset();
}

// Visitors see one era give way to the next; the rest of new content is as if it had always been there.
std::optional<FlatPicture> RenderLoop::what_fades_into(const Content& content) {
  if (!content.config.visitor || !target_size_ || !content.eras || content.eras != content_->eras) return std::nullopt;
  if (!is_building_seen() || !screen_.display()->context().make_current()) return std::nullopt;
  auto scene = screen_.stage().still_scene(target_size_->first, target_size_->second);
  if (scene) return std::move(*scene);
  spdlog::warn("era: shown without fading: {}", scene.error().message);
  return std::nullopt;
}

// Which era is to be seen is the reload's to bring about.
void RenderLoop::follow_visitor() {
  visitor_.step(mailboxes_.reload.era_refused);
  if (mailboxes_.reload.era_further.exchange(visitor_.era()) != visitor_.era()) mailboxes_.reload.bell.ring();
}

void RenderLoop::answer(const std::optional<StageAnswer>& answer) {
  if (!answer) return;
  mailboxes_.reload.answer.put(*answer);
  mailboxes_.reload.bell.ring();
}

// What is ready is shown before the next is begun, which takes its place: else it would be made once more, whole, while
// nothing is drawn. It was put into its mailbox before the next was ordered, and is looked for after.
void RenderLoop::take_order() {
  if (auto order = mailboxes_.render.order.take()) order_ = std::move(*order);
  take_content();
  if (order_ && !new_content_) next_.order(*std::exchange(order_, std::nullopt));
}

// Pictures go first: what takes longer than a few milliseconds, or than the picture itself where drawing is slow, waits
// for the next step.
void RenderLoop::prepare_next_stage() {
  take_order();
  if (!next_.is_unfinished()) return;
  auto* display = screen_.display();
  if (!display) return answer(next_.lose());
  if (!display->context().make_current()) return;  // beginning the next picture says why
  Rehearsal rehearsal{.sky = sky_.report, .layout = layout_, .view = visitor_.view()};
  if (target_size_) std::tie(rehearsal.target_width, rehearsal.target_height) = *target_size_;
  const auto began = clock_.now();
  const auto longest = std::clamp<Duration>(began - turned_, kPreparingTime, kLongestPreparing);
  for (int i = 1; next_.is_unfinished(); ++i) {
    answer(next_.work(display->context(), rehearsal));
    const Duration taken = clock_.now() - began;
    if (taken >= longest || (taken <= Duration::zero() && i >= kMostPreparingPieces)) break;
  }
}

void RenderLoop::read_mailbox() {
  read_sky();
  if (auto camera = mailboxes_.render.scene_camera.take()) {
    if (camera->outages != camera_.outages) {
      shown_.reset();  // redraw at once, so that the driver's buffer is released
      screen_.lose_camera();
    }
    if (camera->frame_interval != camera_.frame_interval)
      ladder_.adopt(patient_with(content_->config.ladder, camera->frame_interval));
    camera_ = std::move(*camera);
  }
  if (auto frame = mailboxes_.render.frames.take()) waiting_ = std::move(*frame);
  if (const auto horizon = mailboxes_.render.horizon.take(); horizon && screen_.is_open())
    screen_.stage().scene().adopt(*horizon);
  if (auto layer = mailboxes_.render.layer.take(); layer && screen_.is_open())
    screen_.stage().scene().adopt(std::move(*layer));
  if (const auto kind = mailboxes_.render.snapshot.take()) snapshots_.request(*kind, content_->config, clock_.now());
  if (waiting_ && waiting_->outages < camera_.outages) waiting_.reset();
}

// While the sky's loop is silent, the sun moves on and the air grows older all the same.
void RenderLoop::read_sky() {
  const auto now = clock_.now();
  if (auto sky = mailboxes_.render.sky.take()) {
    sky_ = told_sky_ = std::move(*sky);
    sky_as_of_ = sky_.told;
  }
  if (!sky_as_of_ || now - *sky_as_of_ < kSkySilence) return;
  sky_.report = aged(told_sky_.report, now - told_sky_.told, content_->config.installation);
  sky_as_of_ = now;
}

void RenderLoop::discard_frames() {
  if (waiting_) picture_at_ = clock_.now();  // with a display there would be a picture
  waiting_.reset();
}

LadderInput RenderLoop::ladder_input() const {
  LadderInput input;
  if (picture_at_) input.picture_age = clock_.now() - *picture_at_;
  input.bad_scene_picture = trouble_of(camera_.health.condition);
  input.sky_up = sky_.up && !mailboxes_.sky.pulse.hung(clock_.now());
  input.sun_known = sky_.sun_known();
  input.open = is_open();
  input.display = screen_.is_open();
  input.unseen = screen_.is_open() && screen_.nothing_shown();
  return input;
}

// While the clock is not trusted, opening hours are ignored.
bool RenderLoop::is_open() const {
  const auto& config = content_->config;
  return !sky_.clock_trusted || config.opening.is_awake(clock_.utc(), config.wake_before);
}

void RenderLoop::update_rung() {
  const auto before = status_.rung;
  status_.rung = ladder_.step(clock_.now(), ladder_input());
  if (status_.rung.shown == before.shown && status_.rung.trouble == before.trouble) return;
  if (status_.rung.shown == Shown::held || before.shown == Shown::held) return;  // brief, and the camera's log says why
  const auto why = name_of(status_.rung.trouble);
  spdlog::info("shown: {}{}{}", name_of(status_.rung.shown), why.empty() ? "" : ": ", why);
}

std::vector<std::string> RenderLoop::words() const {
  std::vector<std::string> lines{snapshots_.words(clock_.now()), visible_message(), visitor_.note()};
  std::erase(lines, "");
  return lines;
}

Composition RenderLoop::composition() const {
  Composition all{status_.rung, fmt::format("{}", fmt::join(words(), "\n"))};
  if (!visitor_.is_there()) return all;
  all.language = visitor_.language();
  all.print = visitor_.print();
  // Where there is no building, then is as now.
  if (!is_building_seen()) return all;
  const auto shown = screen_.stage().scene().shown_view();
  all.hand = hand_view(visitor_.bare(), sky_.report, visitor_.language(), shown, visitor_.hour_of(shown));
  all.view = visitor_.view();
  if (fading_since_) all.before = std::max(0.0, 1.0 - to_seconds(clock_.now() - *fading_since_) / to_seconds(kEraFade));
  all.hints = visitor_.hints();
  all.story = visitor_.story();
  return all;
}

// All but the picture itself.
Snapshot RenderLoop::snapshot_facts() const {
  auto texts = words();
  if (const auto& caption = content_->config.still.caption; status_.rung.still > 0.0 && !caption.empty())
    texts.insert(texts.begin(), caption);
  if (shown_ && !shown_->hand.then.empty()) texts.insert(texts.end(), {shown_->hand.now, shown_->hand.then});
  if (shown_ && !shown_->story.text.empty()) texts.insert(texts.end(), {shown_->story.title, shown_->story.text});
  return snapshot_of(status_, is_building_seen(), texts, clock_.utc());
}

bool RenderLoop::is_building_seen() const {
  return screen_.is_open() && screen_.stage().draws_object() && status_.rung.still < 1.0 && status_.rung.dark < 1.0;
}

// The start before compiled the same shaders, and nothing has to be drawn for long.
bool RenderLoop::can_begin_live() const {
  return waiting_ && sky_.sun_known() && screen_.stage().scene().has_layer_for(sky_.report);
}

// For the next start, unless that was done less than `after` ago.
void RenderLoop::keep_layer(Duration after) {
  const auto now = clock_.now();
  if (now - layer_kept_at_ < after || !content_->config.state_folder || !sky_.clock_trusted || !is_building_seen())
    return;
  auto layer = screen_.stage().scene().layer_to_keep();
  if (!layer) return;
  layer_kept_at_ = now;
  mailboxes_.status->layer.put({content_, clock_.utc(), std::move(*layer)});
}

// While the air is still known, visitors need not hear of a missing sky camera.
std::string RenderLoop::visible_message() const {
  const auto& options = content_->config.messages;
  const auto language = visitor_.is_there() ? visitor_.language() : options.language;
  const auto trouble = status_.rung.trouble;
  const auto message = message_of(trouble);
  const auto* air = sky_.report.seen_air();
  // Whoever has just changed the content stands before the screen now, or never.
  const bool tells_content = options.show_faults && content_->instead && clock_.now() - started_ < kContentMessage;
  if (!message && tells_content) return std::string(message_text(Message::earlier_content, language));
  if (!options.show_faults || !message || (trouble == Trouble::sky_lost && air && air->trustworthy)) return {};
  return std::string(message_text(*message, language));
}

bool RenderLoop::is_due(Instant now) const {
  return waiting_ || !shown_ || *shown_ != composition() || now - shown_at_ >= kRefreshInterval ||
         snapshots_.is_due(now);
}

void RenderLoop::handle_screen_fault(const Fault& fault) {
  if (fault.kind == FaultKind::end_of_stream) {
    closed_ = true;
    return;
  }
  answer(next_.lose());
  screen_.handle_fault(fault);
  status_.building_drawn = false;
  latency_.forget_pending();
}

// Asleep once the screen has faded to black; at the start not before it is known whether it is open.
void RenderLoop::tell_television() {
  const bool on = !is_closed();
  if (!sky_as_of_ || (on && !is_open()) || television_on_ == on) return;
  television_on_ = on;
  mailboxes_.television.on.put(on);
  mailboxes_.television.bell.ring();
}

// Closed: shows a last black picture, then turns the screen off where it can. true: it is off, draw nothing.
bool RenderLoop::turn_off_if_closed() {
  if (!is_closed()) {
    screen_.stay_on();
    return false;
  }
  waiting_.reset();
  picture_at_.reset();  // yesterday's picture must not appear in the morning
  if (shown_ && shown_->rung.dark >= 1.0)
    if (auto off = screen_.turn_off(); !off) {
      handle_screen_fault(off.error());
      return true;
    }
  if (screen_.is_off()) watchdog_.display_off(clock_.now());
  return screen_.is_off();
}

void RenderLoop::present() {
  const auto target = screen_.begin();
  if (!target) return handle_screen_fault(target.error());
  if (!*target) return;
  target_size_ = {(*target)->width, (*target)->height};

  read_mailbox();  // a newer frame may have arrived while waiting for the buffer
  // The still picture goes first: a driver may take long to compile the scene's shaders, and the screen must not be
  // black meanwhile.
  const bool unseen = (screen_.nothing_shown() && !can_begin_live()) || is_closed();
  const auto frame = unseen ? std::nullopt : std::exchange(waiting_, std::nullopt);
  const auto* newest = frame ? &*frame : nullptr;
  const auto holder = frame ? frame->holder : nullptr;
  screen_.stage().scene().set_view(visitor_.view());
  screen_.stage().scene().set_bare(composition().hand.bare);
  const auto uploaded_before = screen_.stage().scene().frames().uploaded;
  const auto on_planes = try_planes(newest, **target);
  if (!on_planes) return handle_screen_fault(on_planes.error());
  auto number = Result<std::uint64_t>(on_planes->number);
  if (on_planes->outcome == PlaneMode::Outcome::compose)
    number = compose(on_planes->taken ? nullptr : newest, **target, holder);
  if (!number) return handle_screen_fault(number.error());
  status_.uploads += screen_.stage().scene().frames().uploaded - uploaded_before;
  shown_at_ = clock_.now();
  if (on_planes->outcome == PlaneMode::Outcome::left_out) return;

  snapshots_.told(clock_.now());
  status_.building_drawn = is_building_seen();
  auto& scene = screen_.stage().scene();
  status_.ground_known = scene.around().ground().known;
  status_.cards = scene.air().cards();
  ++status_.pictures;
  if (!frame) return;
  if (auto question = scene.around().take_question()) {
    mailboxes_.horizon.question.put(std::move(*question));
    mailboxes_.horizon.bell.ring();
  }
  if (auto question = scene.layer().take_question()) {
    mailboxes_.horizon.layer_question.put(std::move(*question));
    mailboxes_.horizon.bell.ring();
  }
  keep_layer(kLayerInterval);
  ++status_.scene_frames;
  layout_ = frame->picture.view().layout;
  latency_.shown(*number, frame->metadata.captured_at);
}

// Errors: device, disconnected.
Result<Screen::OnPlanes> RenderLoop::try_planes(const SceneFrame* frame, const DrawTarget& target) {
  const auto tried = screen_.try_planes(frame, sky_.report, composition(), [&]() -> Result<> {
    if (!snapshots_.is_due(clock_.now())) return {};
    // As the GPU would compose it.
    if (auto drawn = screen_.stage().draw_scene(nullptr, sky_.report, target); !drawn) return drawn;
    return snapshots_.take(snapshot_facts(), target, clock_.now());
  });
  if (!tried) return tried;
  if (frame && (tried->taken || tried->outcome == PlaneMode::Outcome::left_out)) good_picture_came();
  if (tried->outcome != PlaneMode::Outcome::shown) return tried;
  update_rung();
  if (auto now = composition(); now.over_scene().empty()) shown_ = std::move(now);  // else it is due at once
  return tried;
}

// Through the GPU. Errors: device, disconnected.
Result<std::uint64_t> RenderLoop::compose(const SceneFrame* frame, const DrawTarget& target,
                                          std::shared_ptr<const void> until_replaced) {
  if (auto drawn = draw(frame, target); !drawn) return fail(drawn.error());
  if (snapshots_.is_due(clock_.now()))
    if (auto taken = snapshots_.take(snapshot_facts(), target, clock_.now()); !taken) return fail(taken.error());
  return screen_.show(std::move(until_replaced));
}

void RenderLoop::good_picture_came() {
  picture_at_ = clock_.now();
  refused_in_a_row_ = 0;
  status_.draw_refused.clear();
}

// Errors: device.
Result<> RenderLoop::draw(const SceneFrame* frame, const DrawTarget& target) {
  auto& stage = screen_.stage();
  const auto dropped = screen_.drop_lost_buffers();
  if (!dropped) return fail(dropped.error());
  if (*dropped) ++status_.camera_buffers_dropped;
  auto drawn = stage.draw_scene(frame, sky_.report, target);
  if (drawn && frame) good_picture_came();
  if (!drawn && drawn.error().kind == FaultKind::bad_input) {
    if (frame) refuse(drawn.error());
    drawn = stage.draw_scene(nullptr, sky_.report, target);
  }
  if (!drawn) return drawn;
  update_rung();
  shown_ = composition();
  return stage.draw_over(*shown_, sky_.report, target);
}

// A single one was captured before the content changed, and has another size.
void RenderLoop::refuse(const Fault& why) {
  if (++refused_in_a_row_ < 2 || status_.draw_refused == why.message) return;
  status_.draw_refused = why.message;
  spdlog::warn("scene camera: its pictures cannot be drawn: {}", why.message);
}

void RenderLoop::record_flips() {
  if (!screen_.is_open()) return;
  for (const auto& flip : screen_.take_flips()) {
    latency_.flipped(flip.number, flip.at);
    watchdog_.picture_shown(clock_.now());
  }
}

void RenderLoop::finish() {
  record_flips();
  waiting_.reset();
  next_.lose();
  keep_layer({});
  screen_.close();
  status_.rung.shown = Shown::nothing;
  status_.rung.trouble = screen_.refused().empty() ? Trouble::stopped : Trouble::starting;
  published_at_.reset();
  publish();
}

void RenderLoop::publish() {
  const auto now = clock_.now();
  if (published_at_ && now - *published_at_ < kRenderStatusInterval) return;
  published_at_ = now;
  status_.told = now;
  status_.frames_dropped = mailboxes_.render.frames.dropped();
  status_.latency = latency_.whole();
  screen_.report_drawing();
  status_.passers.reset();
  if (const auto* look = screen_.is_open() ? screen_.stage().scene().around().passers() : nullptr)
    status_.passers = PassersStatus{look->state, look->known_share, look->covered_share, look->until_watching};
  status_.page_pictures = snapshots_.page_pictures();
  status_.visitor = visitor_.status();
  if (now - minute_began_ >= 1min) {
    minute_began_ = now;
    status_.latency_minute = latency_.take_minute();
  }
  mailboxes_.proving.see(status_.scene_frames, camera_.frame_interval, status_.rung.shown == Shown::dark);
  mailboxes_.status->render.put(status_);
}

}  // namespace kasumi
