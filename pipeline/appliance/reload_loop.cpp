#include "pipeline/appliance/reload_loop.hpp"

#include <new>
#include <sstream>

#include <spdlog/spdlog.h>

#include "pipeline/machine/memory_left.hpp"
#include "pipeline/stage/stage_making.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kAnswerDeadline = 5min;  // a slow GPU with a heavy model; a loop that hangs is the watchdog's
constexpr Duration kReloadPollInterval = 10s;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// One budget for both: the old content stays until the new one is whole.
Result<> fits_beside_the_old(const Content& content, const std::optional<std::uint64_t>& left) {
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

ReloadLoop::ReloadLoop(ContentPlace place, Clock& clock, Notifier& notifier, Mailboxes& mailboxes, Probes probes)
    : place_(std::move(place)), clock_(clock), notifier_(notifier), mailboxes_(mailboxes), probes_(std::move(probes)) {
  if (!probes_.try_drawing) probes_.try_drawing = try_drawing_here;
  if (!probes_.memory_left) probes_.memory_left = [] { return memory_left(); };
}

void ReloadLoop::ask() {
  asked_ = true;
  mailboxes_.reload.bell.ring();
}

Instant ReloadLoop::step() {
  if (waiting_) take_answer();
  if (!waiting_ && asked_.exchange(false)) begin();
  return waiting_ ? waiting_->until : clock_.now() + kReloadPollInterval;
}

void ReloadLoop::begin() {
  began_ = clock_.now();
  notifier_.reloading();
  publish("reading");
  try {
    config_file_ = place_.configuration();
    auto content = read_content(config_file_);
    if (!content) return refuse(content.error().message);
    if (auto fits = fits_beside_the_old(**content, probes_.memory_left()); !fits) return refuse(fits.error().message);
    order(std::move(*content));
  } catch (const std::bad_alloc&) {
    refuse("there is not enough memory for the new content beside the old one");
  }
}

void ReloadLoop::order(ContentPtr content) {
  auto prepared = prepare_stage(*content);
  publish("preparing");
  waiting_ = {content, prepared, clock_.now() + kAnswerDeadline};
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
  spdlog::info("{}: reloaded", config_file_.string());
  for (Mailbox* mailbox : mailboxes_.all()) mailbox->content.put(waiting_->content);
  end({});
}

void ReloadLoop::refuse(const std::string& problems) {
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
