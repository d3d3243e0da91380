#include "pipeline/kiosk/appliance/check_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/install/camera_drift/drift_reference.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kCheckPollInterval = 10s;        // for the hour of the check
constexpr Duration kGatheringPollInterval = 200ms;  // for requested pictures

// A reference next to the calibration file comes first; the service may write only into its state folder.
std::optional<DriftReference> find_reference(const std::filesystem::path& installed, const std::filesystem::path& own,
                                             const Installation& installation) {
  for (const auto& stem : {installed, own}) {
    auto reference = load_reference(stem, installation);
    if (reference && belongs_to(*reference, installation)) return std::move(*reference);
    if (!reference && reference.error().kind == FaultKind::bad_input)
      spdlog::warn("check: {}", reference.error().message);
  }
  return std::nullopt;
}

std::filesystem::path own_reference(const std::filesystem::path& state_folder) {
  return state_folder / "calibration";
}

}  // namespace

CheckLoop::CheckLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes)
    : content_(std::move(content)), clock_(clock), mailboxes_(mailboxes) {}

Instant CheckLoop::step() {
  mailboxes_.check.pulse.turn(clock_.now(), kBehindBound);
  if (const auto content = mailboxes_.check.content.take()) {
    content_ = *content;
    frames_.reset();
    done_today_ = false;
  }
  if (content_->config.state_folder && !pictures_replaced_) {
    pictures_replaced_ = true;
    const auto own = own_reference(*content_->config.state_folder);
    if (auto replaced = replace_kept_pictures(own, content_->config.installation); !replaced)
      spdlog::warn("check: {}", replaced.error().message);
  }
  const auto& options = content_->config.check;
  const auto now = clock_.now();
  if (!options.hours || !content_->config.state_folder) return now + kCheckPollInterval;
  const bool time = mailboxes_.check.clock_trusted && options.hours->is_open(clock_.utc());
  if (frames_) {
    take_pictures();
    const auto full = [](const auto& pictures) { return pictures.size() >= std::size_t{kMostCheckFrames}; };
    if ((full(frames_->scene()) && full(frames_->sky())) || !time) {
      mailboxes_.scene.check_wants_picture = mailboxes_.sky.check_wants_picture = false;
      judge();
      frames_.reset();
      done_today_ = true;
    }
  }
  if (!time) done_today_ = false;
  if (!time || done_today_) return now + kCheckPollInterval;
  if (!frames_) {
    frames_.emplace(content_->config.installation);
    mailboxes_.check.scene.take();
    mailboxes_.check.sky.take();
    due_ = now;
  }
  if (now >= due_) {
    mailboxes_.scene.check_wants_picture = frames_->scene().size() < std::size_t{kMostCheckFrames};
    mailboxes_.sky.check_wants_picture = frames_->sky().size() < std::size_t{kMostCheckFrames};
    due_ = now + options.length / (kMostCheckFrames + 1);
  }
  return now + kGatheringPollInterval;
}

void CheckLoop::take_pictures() {
  if (const auto scene = mailboxes_.check.scene.take()) frames_->add_scene(view_of(scene->picture));
  if (const auto sky = mailboxes_.check.sky.take())
    frames_->add_sky(view_of(sky->picture), sky->metadata,
                     sky->time_known ? std::optional(sky->metadata.utc) : std::nullopt);
}

void CheckLoop::judge() {
  const auto& installation = content_->config.installation;
  const auto now = clock_.utc();
  const auto enough = std::size_t{kFewestCheckFrames};
  if (frames_->scene().size() < enough && frames_->sky().size() < enough)
    return publish("not checked: too few pictures arrived", std::nullopt, true);
  const auto own = own_reference(*content_->config.state_folder);
  if (const auto reference =
          find_reference(reference_stem(installation, content_->files.front().path), own, installation)) {
    auto report = find_drift(*frames_, *reference, installation, now);
    auto summary = drift_summary(report);
    const bool steady = report.steady();
    return publish(std::move(summary), std::move(report), !steady);
  }
  const auto taken = take_reference(*frames_, installation, now);
  if (!taken) return publish("no reference could be made: " + taken.error().message, std::nullopt, true);
  if (auto saved = save_reference(*taken, own); !saved) return publish(saved.error().message, std::nullopt, true);
  publish(fmt::format("today's view is the reference from now on ({}.check.json)", own.string()), std::nullopt, false);
}

void CheckLoop::publish(std::string summary, std::optional<DriftReport> report, bool warn) {
  spdlog::log(warn ? spdlog::level::warn : spdlog::level::info, "calibration: {}", summary);
  mailboxes_.status->check.put({clock_.utc(), std::move(summary), std::move(report)});
}

}  // namespace kasumi
