#include "pipeline/appliance/check_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/appliance/status_mail.hpp"
#include "pipeline/camera_drift/drift_reference.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLookForHour = 10s;  // for the hour to come
constexpr Duration kGathering = 200ms;  // for pictures that were asked for

// What is written goes into the state's folder: beside the calibration file the service may not write.
std::optional<DriftReference> find_reference(const std::filesystem::path& beside, const std::filesystem::path& own,
                                             const Installation& installation) {
  for (const auto& stem : {beside, own}) {
    auto reference = load_reference(stem);
    if (reference && belongs_to(*reference, installation)) return std::move(*reference);
    if (!reference && reference.error().kind == FaultKind::bad_input)
      spdlog::warn("check: {}", reference.error().message);
  }
  return std::nullopt;
}

}  // namespace

CheckLoop::CheckLoop(ContentPtr content, std::filesystem::path config_file, Clock& clock, Exchange& exchange)
    : content_(std::move(content)), config_file_(std::move(config_file)), clock_(clock), exchange_(exchange) {}

Instant CheckLoop::step() {
  if (const auto content = exchange_.check.content.take()) {
    content_ = *content;
    frames_.reset();
    done_ = false;
  }
  const auto& choice = content_->config.check;
  const auto now = clock_.now();
  if (!choice.hours || !content_->config.state_folder) return now + kLookForHour;
  const bool time = exchange_.check.clock_trusted && choice.hours->is_open(clock_.utc());
  if (frames_) {
    take_pictures();
    const auto full = [](const auto& pictures) { return pictures.size() >= std::size_t{kMostCheckFrames}; };
    if ((full(frames_->scene()) && full(frames_->sky())) || !time) {
      exchange_.scene.check_wants_picture = exchange_.sky.check_wants_picture = false;
      judge();
      frames_.reset();
      done_ = true;
    }
  }
  if (!time) done_ = false;
  if (!time || done_) return now + kLookForHour;
  if (!frames_) {
    frames_.emplace(content_->config.installation);
    exchange_.check.scene.take();
    exchange_.check.sky.take();
    due_ = now;
  }
  if (now >= due_) {
    exchange_.scene.check_wants_picture = frames_->scene().size() < std::size_t{kMostCheckFrames};
    exchange_.sky.check_wants_picture = frames_->sky().size() < std::size_t{kMostCheckFrames};
    due_ = now + choice.length / (kMostCheckFrames + 1);
  }
  return now + kGathering;
}

void CheckLoop::take_pictures() {
  if (const auto scene = exchange_.check.scene.take()) frames_->add_scene(view_of(scene->picture));
  if (const auto sky = exchange_.check.sky.take())
    frames_->add_sky(view_of(sky->picture), sky->metadata,
                     sky->time_known ? std::optional(sky->metadata.utc) : std::nullopt);
}

void CheckLoop::judge() {
  const auto& installation = content_->config.installation;
  const auto now = clock_.utc();
  const auto enough = std::size_t{kFewestCheckFrames};
  if (frames_->scene().size() < enough && frames_->sky().size() < enough)
    return tell("not done: too few pictures came", std::nullopt, true);
  const auto own = *content_->config.state_folder / "calibration";
  if (const auto reference = find_reference(reference_stem(installation, config_file_), own, installation)) {
    auto report = find_drift(*frames_, *reference, installation, now);
    auto summary = drift_summary(report);
    const bool well = report.well();
    return tell(std::move(summary), std::move(report), !well);
  }
  const auto taken = take_reference(*frames_, installation, now);
  if (!taken) return tell("no reference could be taken: " + taken.error().message, std::nullopt, true);
  if (auto saved = save_reference(*taken, own); !saved) return tell(saved.error().message, std::nullopt, true);
  tell(fmt::format("what is seen now is the reference from now on ({}.check.json)", own.string()), std::nullopt, false);
}

void CheckLoop::tell(std::string summary, std::optional<DriftReport> report, bool warn) {
  spdlog::log(warn ? spdlog::level::warn : spdlog::level::info, "calibration: {}", summary);
  exchange_.status->check.put({clock_.utc(), std::move(summary), std::move(report)});
}

}  // namespace kasumi
