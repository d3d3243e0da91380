#include "pipeline/kiosk/appliance/reload_loop.hpp"

#include <algorithm>
#include <new>

#include <spdlog/spdlog.h>

#include "base/outside/lines.hpp"
#include "pipeline/machine/memory_left.hpp"
#include "pipeline/show/stage/stage_making.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kAnswerDeadline = 5min;   // a slow GPU with a heavy model; a loop that hangs is the watchdog's
constexpr Duration kReadingDeadline = 1min;  // of everything that the content names
// What reads longer may hang, and a newer request takes its place. Many requests in a row must not read side by side.
constexpr Duration kReadingPatience = 5s;
constexpr Duration kReadingLook = 50ms;  // by the machine's clock
constexpr int kReadingLooks = 20;        // a step
// Looks cost file system calls: a reload is awaited by a person, an era's change by the minute.
constexpr Duration kReloadPollInterval = 10s;
constexpr Duration kEraPollInterval = 1s;
constexpr Duration kRefusedEraPause = 10min;  // before it is tried again

// One budget for both: the old content stays until the new one is whole.
Result<> fits_beside_the_old(const Content& content, const std::optional<std::uint64_t>& left) {
  // Left to the rest of the machine: no reload may bring it to swap.
  constexpr std::uint64_t kMega = 1'000'000, kReserve = 100 * kMega;
  const auto needed = bytes_to_stage(content) + kReserve;
  if (!left || needed <= *left) return {};
  return fail(FaultKind::bad_input,
              "the new content needs {} MB of memory beside the old one, but {} MB are left: expected smaller textures "
              "or fewer triangles (or restart the service, which shows a still picture for some seconds)",
              needed / kMega, *left / kMega);
}

Result<> try_drawing_here(const ContentPtr& content, const std::shared_ptr<const PreparedStage>& prepared) {
  std::string renderer;
  auto drawn = try_drawing(content, prepared, renderer);
  if (!drawn && renderer.empty()) {  // no GL without a display: nothing more can be found out now
    spdlog::warn("reload: not tried whether the content can be drawn: {}", drawn.error().message);
    return {};
  }
  return drawn;
}

}  // namespace

ReloadLoop::ReloadLoop(ContentPlace place, ContentPtr content, Clock& clock, Notifier& notifier, Mailboxes& mailboxes,
                       Probes probes)
    : place_(std::move(place)),
      content_(std::move(content)),
      clock_(clock),
      notifier_(notifier),
      mailboxes_(mailboxes),
      probes_(std::move(probes)),
      era_again_(clock.now()) {
  if (!probes_.try_drawing) probes_.try_drawing = try_drawing_here;
  if (!probes_.memory_left) probes_.memory_left = [] { return memory_left(); };
}

void ReloadLoop::ask() {
  asked_ = true;
  mailboxes_.reload.bell.ring();
}

Instant ReloadLoop::step() {
  mailboxes_.reload.pulse.turn(clock_.now(), kReloadPollInterval + kComputingBound);
  if (waiting_) leave_era();
  if (waiting_) take_answer();
  if (!waiting_ && asked_.exchange(false)) begin();
  if (reading_) take_content();
  if (reading_) return clock_.now();
  if (!waiting_) change_era();
  if (waiting_) return std::min(waiting_->until, clock_.now() + kReloadPollInterval);
  return clock_.now() + (content_->eras ? kEraPollInterval : kReloadPollInterval);
}

void ReloadLoop::begin() {
  began_ = clock_.now();
  notifier_.reloading();
  publish("reading");
  config_file_ = place_.config;
  try {
    reading_.emplace(
        Reading{Abandonable<Result<ContentPtr>>([place = place_] { return read_content(place.configuration()); }),
                began_ + kReadingPatience, began_ + kReadingDeadline});
  } catch (const std::exception& thrown) {
    refuse(fmt::format("{}: it cannot be read now: {}", config_file_.string(), thrown.what()));
  }
}

// Checks at intervals for a new request and for the deadline.
void ReloadLoop::take_content() {
  try {
    std::optional<Result<ContentPtr>> content;
    const auto is_superseded = [&] { return asked_ && clock_.now() >= reading_->patient_until; };
    for (int i = 0; i < kReadingLooks && !content && !is_superseded() && clock_.now() < reading_->until; ++i)
      content = reading_->content.take(kReadingLook);
    if (!content && is_superseded()) return reading_.reset();
    if (!content && clock_.now() < reading_->until) return;
    reading_.reset();
    if (!content)
      return refuse(fmt::format("{}: reading it and what it names takes longer than {:.0f} s: does the disk answer?",
                                config_file_.string(), to_seconds(kReadingDeadline)));
    if (!*content) return refuse(content->error().message);
    config_file_ = (**content)->files.front().path;
    if (auto fits = fits_beside_the_old(***content, probes_.memory_left()); !fits) return refuse(fits.error().message);
    order(in_its_era(**content, clock_.utc()), Change::reload);
  } catch (const std::bad_alloc&) {
    reading_.reset();
    refuse("there is not enough memory for the new content beside the old one");
  } catch (const std::exception& thrown) {  // no thread is left, for one
    reading_.reset();
    refuse(fmt::format("{}: it cannot be made ready now: {}", config_file_.string(), thrown.what()));
  }
}

// By a clock that is not trusted the era stays as it is; then there is no building to see either.
void ReloadLoop::change_era() {
  if (!content_->eras || !mailboxes_.check.clock_trusted) return;
  auto content = in_its_era(content_, clock_.utc(), mailboxes_.reload.era_further);
  if (content == content_ || (content->era == refused_era_ && clock_.now() < era_again_)) return;
  try {
    waiting_ = {content, nullptr, clock_.now(), Change::era};
    if (auto fits = fits_beside_the_old(*content, probes_.memory_left()); !fits)
      return refuse_era(fits.error().message);
    order(std::move(content), Change::era);
  } catch (const std::bad_alloc&) {
    refuse_era("there is not enough memory for it beside the one before");
  }
}

// A visitor has chosen on, or gone: nobody is to see what is prepared still.
void ReloadLoop::leave_era() {
  if (waiting_->change != Change::era) return;
  if (in_its_era(content_, clock_.utc(), mailboxes_.reload.era_further)->era == waiting_->content->era) return;
  mailboxes_.render.order.put({++orders_, nullptr, nullptr});
  waiting_.reset();
  publish({});
}

void ReloadLoop::order(ContentPtr content, Change change) {
  auto prepared = prepare_stage(*content);
  publish("preparing");
  waiting_ = {content, prepared, clock_.now() + kAnswerDeadline, change};
  mailboxes_.reload.answer.take();
  mailboxes_.render.order.put({++orders_, std::move(content), std::move(prepared)});
  mailboxes_.render.bell.ring();
}

void ReloadLoop::take_answer() {
  const auto answer = mailboxes_.reload.answer.take();
  if (!answer || answer->number != orders_) {
    if (clock_.now() < waiting_->until) return;
    mailboxes_.render.order.put({++orders_, nullptr, nullptr});
    return refuse("the picture's loop gave no answer");
  }
  switch (answer->kind) {
    case StageAnswer::Kind::ready: return adopt();
    case StageAnswer::Kind::refused: return refuse(answer->problem);
    case StageAnswer::Kind::no_display: break;
  }
  publish("preparing without a display");
  const auto drawn = probes_.try_drawing(waiting_->content, waiting_->prepared);
  drawn ? adopt() : refuse(drawn.error().message);
}

void ReloadLoop::adopt() {
  if (waiting_->change == Change::era) return adopt_era();
  content_ = waiting_->content;
  spdlog::info("{}: reloaded", config_file_.string());
  for (Mailbox* mailbox : mailboxes_.all()) mailbox->content.put(content_);
  forget_refused_era();
  end({});
}

// Cameras, air and checks go on undisturbed: an era changes nothing for them.
void ReloadLoop::adopt_era() {
  content_ = waiting_->content;
  waiting_.reset();
  // A visitor may ask for the refused one again: its problem stays for operators.
  if (!content_->config.visitor || refused_era_ == content_->era || clock_.now() >= era_again_) forget_refused_era();
  spdlog::info("era: {}", era_name(*content_));
  mailboxes_.render.content.put(content_);
  mailboxes_.status->content.put(content_);
  publish({});
  mailboxes_.render.bell.ring();
}

void ReloadLoop::refuse_era(const std::string& problems) {
  auto text = fmt::format("the era \"{}\" cannot be shown, keeping \"{}\": {}", era_name(*waiting_->content),
                          era_name(*content_), problems);
  refused_era_ = mailboxes_.reload.era_refused = waiting_->content->era;
  waiting_.reset();
  era_again_ = clock_.now() + kRefusedEraPause;
  if (text != status_.era_problem) spdlog::error("{}", text);
  status_.era_problem = std::move(text);
  publish({});
  mailboxes_.render.bell.ring();
}

void ReloadLoop::forget_refused_era() {
  status_.era_problem.clear();
  refused_era_.reset();
  mailboxes_.reload.era_refused = kNoEra;
}

void ReloadLoop::refuse(const std::string& problems) {
  if (waiting_ && waiting_->change == Change::era) return refuse_era(problems);
  auto lines = lines_of(problems);
  spdlog::error("the new content is refused, keeping the old content:");
  for (const auto& line : lines) spdlog::error("  {}", line);
  end(std::move(lines));
}

void ReloadLoop::end(std::vector<std::string> problems) {
  waiting_.reset();
  status_.began = began_;
  status_.ended = clock_.utc();
  status_.problems = std::move(problems);
  publish({});
  mailboxes_.render.bell.ring();
  notifier_.ready();
}

void ReloadLoop::publish(std::string doing) {
  status_.doing = std::move(doing);
  mailboxes_.status->reload.put(status_);
}

}  // namespace kasumi
