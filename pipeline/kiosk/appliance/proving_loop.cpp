#include "pipeline/kiosk/appliance/proving_loop.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "base/files.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kProvingInterval = 5s;  // between looks: bounds how late a proof is noted
constexpr Duration kProof = 10min;         // ten minutes of pictures forgive everything before them (docs/operating.md)
constexpr Duration kKeepAgainInterval = 1h;  // after the disk failed
constexpr Duration kStatusDeadline = 1s;     // to read a file in memory

}  // namespace

ProvingLoop::ProvingLoop(ContentPtr content, ProvingRecords options, ProvingPlaces places, Clock& clock,
                         Mailboxes& mailboxes)
    : content_(std::move(content)),
      options_(std::move(options)),
      status_file_(std::move(places.status_file)),
      clock_(clock),
      mailboxes_(mailboxes),
      probation_(std::move(places.content), std::move(places.reload)),
      stepped_(clock.now()) {
  probation_.adopt(*content_, clock.utc());
  mailboxes_.status->probation.put(probation_.status());
}

bool ProvingLoop::Proof::advance(std::uint64_t count, Duration by, Duration patience) {
  if (count != last)
    last = count, since = Duration{};
  else if (since)
    *since += by;
  if (!since || *since > patience) return false;
  lasted += by;
  return true;
}

Instant ProvingLoop::step() {
  const auto now = clock_.now();
  mailboxes_.proving.pulse.turn(now, kBehindBound);
  if (const auto content = mailboxes_.proving.content.take()) {
    content_ = *content;
    scene_.lasted = {};
    scene_.since = camera_.since = {};
    kept_ = keeping_failed_ = false;
    keep_at_ = {};
    probation_.adopt(*content_, clock_.utc());
    mailboxes_.status->probation.put(probation_.status());
  }
  if (now - stepped_ < kProvingInterval) return stepped_ + kProvingInterval;
  const auto passed = std::min<Duration>(now - stepped_, 2 * kProvingInterval);
  stepped_ = now;
  const bool alive = alive_.advance(mailboxes_.proving.alive, passed);
  const Duration patience = mailboxes_.proving.scene_interval.load() * 5 / 2;  // as with a stall
  const bool scene = scene_.advance(mailboxes_.proving.scene_pictures, passed, patience);
  const bool camera = camera_.advance(mailboxes_.proving.scene_frames, passed, patience);
  if (auto* starts = options_.starts) {
    if (alive && !std::exchange(shown_, true)) {
      starts->shown();
      starts->doing("showing pictures");
    }
    if (alive_.lasted >= kProof && !std::exchange(well_, true)) starts->well();
  }
  if (probation_.in_use()) {
    // While the kiosk is closed nothing is shown, and the camera's pictures must do, so that content that arrives in
    // the evening is judged by the morning.
    probation_.step(passed, scene || (mailboxes_.proving.closed && camera), ask_doctor(passed), clock_.utc());
    mailboxes_.status->probation.put(probation_.status());
  }
  if (scene_.lasted >= kProof && !probation_.holds()) keep();
  return now + kProvingInterval;
}

Probation::FailingChecks ProvingLoop::ask_doctor(Duration passed) {
  Probation::FailingChecks failing;
  if (!status_file_) return failing;
  const auto read = reading_.within(kStatusDeadline, [file = *status_file_] { return read_text_file(file); });
  if (!read || !*read) return failing;
  const auto& status = *read;
  const auto before = std::exchange(status_before_, *status);
  if (before.empty()) return failing;
  Findings findings;
  const auto at = [](const std::string& text) { return RunningAppliance{::getpid(), text, 0.0}; };
  check_appliance(content_->config, at(before), at(*status), to_seconds(passed), findings);
  for (const auto& finding : findings.all())
    if (finding.grade == Grade::failure) failing[finding.check] = finding.found;
  return failing;
}

void ProvingLoop::keep() {
  if (kept_ || options_.kept_folder.empty() || content_->instead || clock_.now() < keep_at_) return;
  const auto kept = keep_content(*content_, options_.kept_folder, clock_.utc());
  kept_ = kept || kept.error().kind == FaultKind::bad_input;  // edited meanwhile: the next reload proves it
  keep_at_ = clock_.now() + kKeepAgainInterval;
  if (!kept && !std::exchange(keeping_failed_, true))
    spdlog::warn("the content is not kept for a start without it: {}", kept.error().message);
  if (kept) spdlog::info("the content has been shown for ten minutes: kept in {}", options_.kept_folder.string());
}

}  // namespace kasumi
