#include "pipeline/kiosk/appliance/screen.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/show/stage/words.hpp"
#include "pipeline/site/config/messages.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kBufferDeadline = 250ms;  // far longer than a flip at 60 Hz
constexpr Duration kStuckDisplay = 1500ms;   // no flip completes: reopen the display
constexpr Duration kDisplayInterval = 1s;    // between attempts to open one
constexpr int kRefusalsForGood = 3;          // one refusal may be the display's; three in a row are the content's
constexpr Duration kRefusalFlip = 1s;        // for the still picture to be on the glass
constexpr Duration kDisplayPause = 250ms;    // the same after a hotplug event

}  // namespace

Screen::Screen(ContentPtr content, Devices& devices, Clock& clock, Watchdog& watchdog, DisplayStatus& status)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      watchdog_(watchdog),
      status_(status),
      watch_(devices.watch_displays()),
      try_at_(clock.now()),
      tried_at_(clock.now() - kDisplayPause) {}

bool Screen::try_open() {
  if (watch_ && watch_->take_change()) try_at_ = std::min(try_at_, tried_at_ + kDisplayPause);
  if (refused_) await_refusal();
  return !refused_ && clock_.now() >= try_at_ && open();
}

bool Screen::open() {
  const auto now = clock_.now();
  tried_at_ = now;
  try_at_ = now + kDisplayInterval;
  auto display = devices_.open_display(content_->config.display);
  auto stage = display ? Stage::create((*display)->context(), content_, std::exchange(air_, std::nullopt))
                       : fail(display.error());
  // A driver may lack memory for a moment, so it is asked again first.
  const bool refused = display && !stage && (*display)->context().check_alive();
  refusals_ = refused ? refusals_ + 1 : 0;
  if (refused && (stage.error().kind == FaultKind::bad_input || refusals_ >= kRefusalsForGood)) {
    show_refusal(std::move(*display), stage.error().message);
    return false;
  }
  if (!stage) {
    status_.up = false;
    status_.cause = (display ? "the content cannot be drawn: " : "") + stage.error().message;
    if (!display && display.error().kind == FaultKind::disconnected) watchdog_.display_missing(now);
    if (!missing_logged_) spdlog::warn("display: not available: {}", status_.cause);
    missing_logged_ = true;
    return false;
  }
  missing_logged_ = false;
  spdlog::info("display: {}, {}", (*display)->description(), (*display)->context().info().renderer);
  for (const auto& note : stage->scene().notes()) spdlog::info("display: {}", note);
  stage->scene().go_live(clock_);
  stage->scene().around().adopt(std::exchange(passers_, std::nullopt));
  status_.up = true;
  status_.description = (*display)->description();
  status_.cause.clear();
  open_ = Open{std::move(*display), std::move(*stage), {}};
  timeouts_since_.reset();
  return true;
}

// Whatever goes wrong here changes nothing: other content comes next.
void Screen::show_refusal(std::unique_ptr<Display> display, std::string why) {
  spdlog::error("display: {}: the content cannot be drawn: {}", display->description(), why);
  status_.cause = "the content cannot be drawn: " + why;
  status_.description = display->description();
  refused_ = Refused{std::move(why), nullptr, clock_.now() + kRefusalFlip};
  try_at_ = clock_.now();
  auto still = StillPicture::create(display->context(), *content_);
  const auto target = display->begin(clock_.now() + kBufferDeadline);
  if (!target) return;
  clear_to(*target, glm::vec3(kStillBackground) / 255.0F);
  const auto& config = content_->config;
  const auto message = config.messages.show_faults ? message_text(Message::safe_mode, config.messages.language) : "";
  Words caption, words;
  if (still) (void)still->draw(*target, {}, 1.0);
  (void)caption.draw(display->context(), config.still.caption, config.messages, false, 1.0, *target);
  (void)words.draw(display->context(), std::string(message), config.messages, true, 1.0, *target);
  if (display->show()) refused_->display = std::move(display);
}

void Screen::await_refusal() {
  const auto now = clock_.now();
  try_at_ = now + kBufferDeadline / 5;
  const bool seen = refused_->display && !refused_->display->take_flips().empty();
  if (seen) ++status_.flips;
  if (seen) watchdog_.picture_shown(now);
  refused_->told = refused_->told || seen || now >= refused_->until;
}

Result<> Screen::adopt(const ContentPtr& content, std::optional<Stage> stage) {
  const bool other_display = content->config.display != content_->config.display;
  if (open_ && !other_display) {
    if (!stage) {
      auto made = Stage::create(open_->display->context(), content);
      if (!made) return fail(made.error());
      stage = std::move(*made);
    }
    open_->planes = {};
    auto passers = open_->stage.scene().around().take_passers();
    open_->stage = std::move(*stage);
    open_->stage.scene().go_live(clock_);
    open_->stage.scene().around().adopt(std::move(passers));
  }
  stage.reset();  // before the context that it belongs to
  content_ = content;
  air_.reset();
  if (other_display) {
    open_.reset();
    try_at_ = clock_.now();
  }
  return {};
}

void Screen::handle_fault(const Fault& fault) {
  spdlog::warn("display: lost: {}", fault.message);
  ++status_.resets;
  status_.up = false;
  status_.cause = fault.message;
  missing_logged_ = true;  // by the warning above
  air_ = open_->stage.scene().air();
  passers_ = open_->stage.scene().around().take_passers();
  open_.reset();
  try_at_ = clock_.now();
}

Result<std::optional<DrawTarget>> Screen::begin() {
  const auto target = open_->display->begin(clock_.now() + kBufferDeadline);
  if (target) {
    timeouts_since_.reset();
    return *target;
  }
  if (target.error().kind != FaultKind::timeout) return fail(target.error());
  ++status_.flip_timeouts;
  const auto now = clock_.now();
  if (!timeouts_since_) timeouts_since_ = now - kBufferDeadline;
  if (now - *timeouts_since_ >= kStuckDisplay) return fail(target.error());
  return std::nullopt;
}

Result<std::uint64_t> Screen::show(std::shared_ptr<const void> until_replaced) {
  if (auto alive = open_->display->context().check_alive(); !alive) return fail(alive.error());
  auto number = open_->display->show(std::move(until_replaced));
  if (number) open_->dark = false;
  return number;
}

// Why the next picture cannot go onto the display's planes; empty: it may.
std::string Screen::against_planes(const SceneFrame* frame, const Composition& composition) const {
  const auto& planes = open_->planes;
  if (!content_->config.planes) return "turned off in the configuration";
  if (planes.given_up()) return planes.state();
  if (open_->dark) return "no picture yet";
  if (content_->config.overlay) return "the overlay is shown";
  if (auto over = composition.over_scene(); !over.empty()) return over;
  if (camera_gone_) return "the scene camera is gone";
  return frame || planes.is_on() ? "" : planes.state();
}

Result<Screen::OnPlanes> Screen::try_planes(const SceneFrame* frame, const SkyReport& sky,
                                            const Composition& composition, const std::function<Result<>()>& before) {
  auto& planes = open_->planes;
  if (auto why = against_planes(frame, composition); !why.empty()) {
    planes.compose(std::move(why));
    return OnPlanes{};
  }
  if (frame && !frame->picture.dma_buf())  // a camera that runs short of buffers copies some
    return OnPlanes{planes.leave_out("the camera's pictures do not lie in buffers that a display can read").outcome};
  if (frame) {
    if (auto took = open_->stage.take_scene(*frame, sky); !took) {
      if (took.error().kind != FaultKind::bad_input) return fail(took.error());
      planes.compose(took.error().message);
      return OnPlanes{};
    }
  }
  if (auto done = before(); !done) return fail(done.error());
  const auto shown = frame ? show_on_planes(frame->holder) : planes.show_again(*open_->display);
  if (!shown) return fail(shown.error());
  return OnPlanes{shown->outcome, shown->number, frame != nullptr};
}

Result<PlaneMode::Attempt> Screen::show_on_planes(std::shared_ptr<const void> until_replaced) {
  auto& planes = open_->planes;
  auto picture = open_->stage.scene_for_planes(*open_->display, clock_.now());
  if (picture) return planes.show(*open_->display, std::move(*picture), std::move(until_replaced));
  if (picture.error().kind != FaultKind::unsupported) return fail(picture.error());
  planes.give_up(picture.error().message);
  return PlaneMode::Attempt{};
}

Result<bool> Screen::drop_lost_buffers() {
  if (!std::exchange(camera_gone_, false)) return false;
  if (auto dropped = open_->stage.scene().drop_camera_buffers(); !dropped) return fail(dropped.error());
  return true;
}

std::vector<Flip> Screen::take_flips() {
  auto flips = open_->display->take_flips();
  status_.flips += flips.size();
  return flips;
}

Result<> Screen::turn_off() {
  if (open_->off || open_->stays_on) return {};
  const auto off = open_->display->turn_off();
  open_->off = off.has_value();
  open_->stays_on = !off && off.error().kind == FaultKind::unsupported;
  if (!off && !open_->stays_on && off.error().kind != FaultKind::timeout) return fail(off.error());
  return {};
}

}  // namespace kasumi
