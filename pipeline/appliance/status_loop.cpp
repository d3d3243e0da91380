#include "pipeline/appliance/status_loop.hpp"

#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "pipeline/appliance/remembered_state.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kStatsInterval = 1min;

// Logs once when writing begins to fail and once when it works again.
void log_outage(const Result<>& written, bool& failing, std::string_view what) {
  if (!written && !failing) spdlog::warn("{}: {}", what, written.error().message);
  if (written && failing) spdlog::info("{}: written again", what);
  failing = !written;
}

}  // namespace

StatusLoop::StatusLoop(ContentPtr content, StatusOptions options, Clock& clock, Notifier& notifier,
                       Mailboxes& mailboxes)
    : content_(std::move(content)),
      options_(std::move(options)),
      clock_(clock),
      notifier_(notifier),
      mailboxes_(mailboxes),
      saved_(clock.now()),
      stats_at_(clock.now()) {
  status_.since = clock.utc();
}

void StatusLoop::gather() {
  const auto newest = [](auto& slot, auto& to) {
    if (auto value = slot.take()) to = std::move(*value);
  };
  StatusMailbox& mailbox = *mailboxes_.status;
  newest(mailbox.content, content_);
  newest(mailbox.scene_camera, status_.scene_camera);
  newest(mailbox.sky_camera, status_.sky_camera);
  newest(mailbox.sky, status_.sky);
  newest(mailbox.render, status_.render);
  newest(mailbox.reload, status_.reload);
  newest(mailbox.check, status_.check);
  newest(mailbox.visibility, status_.visibility);
  status_.now = clock_.now();
  status_.utc = clock_.utc();
}

void StatusLoop::step() {
  gather();
  write_status();
  if (status_.now - saved_ >= options_.save_interval) save_air();
  if (options_.stats && status_.now - stats_at_ >= kStatsInterval) {
    stats_at_ = status_.now;
    spdlog::info("{}", stats_text(status_));
  }
}

void StatusLoop::finish() {
  gather();
  write_status();
  save_air();
  if (options_.stats) spdlog::info("{}", stats_text(status_));
}

void StatusLoop::write_status() {
  if (auto line = status_line(status_); line != line_) notifier_.status(line_ = std::move(line));
  if (options_.file) log_outage(write_text_file(*options_.file, status_json(status_)), write_failing_, "status");
}

void StatusLoop::save_air() {
  saved_ = status_.now;
  const auto& folder = content_->config.state_folder;
  const auto& tracked = status_.sky.report.tracked;
  // What is given needs no memory. Without a trusted clock its age would be unknown after a restart.
  const auto& installation = content_->config.installation;
  if (!folder || !tracked || installation.surroundings.air.whole() || !status_.sky.clock_trusted) return;
  const TurbidityState state =
      turbidity_state(tracked->target, tracked->sigma, status_.utc - tracked->age, installation.sky_to_fit());
  log_outage(save(state, *folder), save_failing_, "state");
}

}  // namespace kasumi
