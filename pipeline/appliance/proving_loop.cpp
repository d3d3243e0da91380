#include "pipeline/appliance/proving_loop.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "pipeline/start/kept_content.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kProvingInterval = 5s;
constexpr Duration kProof = 10min;
constexpr Duration kKeepAgainInterval = 1h;  // after the disk failed

}  // namespace

ProvingLoop::ProvingLoop(ContentPtr content, ProvingOptions options, Clock& clock, Mailboxes& mailboxes)
    : content_(std::move(content)),
      options_(std::move(options)),
      clock_(clock),
      mailboxes_(mailboxes),
      stepped_(clock.now()) {}

bool ProvingLoop::Proof::advance(std::uint64_t count, Duration by) {
  if (count == last) return false;
  last = count;
  lasted += by;
  return true;
}

Instant ProvingLoop::step() {
  const auto now = clock_.now();
  mailboxes_.proving.pulse.turn(now, kBehindBound);
  if (const auto content = mailboxes_.proving.content.take()) {
    content_ = *content;
    scene_.lasted = {};
    kept_ = keeping_failed_ = false;
    keep_at_ = {};
  }
  if (now - stepped_ < kProvingInterval) return stepped_ + kProvingInterval;
  const auto passed = std::min<Duration>(now - stepped_, 2 * kProvingInterval);
  stepped_ = now;
  const bool alive = alive_.advance(mailboxes_.proving.alive, passed);
  scene_.advance(mailboxes_.proving.scene_pictures, passed);
  if (auto* starts = options_.starts) {
    if (alive && !std::exchange(shown_, true)) {
      starts->shown();
      starts->doing("showing pictures");
    }
    if (alive_.lasted >= kProof && !std::exchange(well_, true)) starts->well();
  }
  if (scene_.lasted >= kProof) keep();
  return now + kProvingInterval;
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
