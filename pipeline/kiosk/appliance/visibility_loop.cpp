#include "pipeline/kiosk/appliance/visibility_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/kiosk/start/remembered_state.hpp"
#include "pipeline/show/scene/aged_report.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kVisibilityPollInterval = 10s;  // for new content
constexpr Duration kPictureWaitInterval = 200ms;   // for a requested picture
constexpr int kDisagreementsToReport = 5;          // readings in a row: a lorry in front of a landmark has left by then

}  // namespace

VisibilityLoop::VisibilityLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes)
    : content_(std::move(content)), clock_(clock), mailboxes_(mailboxes) {}

void VisibilityLoop::adopt_content() {
  const auto& installation = content_->config.installation;
  watch_.reset();
  disagreements_ = 0;
  reported_ = false;
  watch_.emplace(installation);
  if (!watch_->any()) watch_.reset();
  if (!watch_ || !watch_->has_landmarks()) return;
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto resumed = resume(watch_->landmarks(), *folder);
  if (!resumed)
    spdlog::warn("visibility: {}", resumed.error().message);
  else if (*resumed)
    watch_->has_learnt(clock_.now());  // the saved state may already include the present light
}

void VisibilityLoop::keep_what_was_learnt() {
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto saved = save(watch_->landmarks(), *folder);
  if (!saved && !save_failing_) spdlog::warn("visibility: {}", saved.error().message);
  save_failing_ = !saved;
}

Instant VisibilityLoop::step() {
  mailboxes_.visibility.pulse.turn(clock_.now(), kBehindBound);
  if (const auto content = mailboxes_.visibility.content.take()) {
    content_ = *content;
    adopt_content();
    mailboxes_.status->visibility.put({});
  } else if (!begun_) {
    adopt_content();
  }
  begun_ = true;
  const auto now = clock_.now();
  if (!watch_) return now + kVisibilityPollInterval;
  if (auto sky = mailboxes_.visibility.sky.take()) sky_ = *sky;
  if (now - sky_.told > kCloudsHold) sky_ = {};  // the sky's loop is silent
  if (const auto picture = mailboxes_.visibility.scene.take()) judge(*picture);
  if (now >= due_) {
    mailboxes_.scene.visibility_wants_picture = true;
    due_ = now + kSceneLookInterval;
  }
  return mailboxes_.scene.visibility_wants_picture ? now + kPictureWaitInterval : due_;
}

void VisibilityLoop::judge(const RequestedFrame& picture) {
  const auto& installation = content_->config.installation;
  if (picture.picture.width() != installation.scene.width || picture.picture.height() != installation.scene.height)
    return;
  auto look = watch_->look(view_of(picture.picture), clock_.now(), sky_.above);
  VisibilityStatus status{clock_.utc(), std::move(look.landmarks), {}, std::move(look.reason)};
  if (status.air && sky_.turbidity) status.sky = watch_->landmarks().compare(*status.air, *sky_.turbidity, sky_.sigma);
  if (!look.air.empty()) mailboxes_.sky.scene_air.put(std::move(look.air));
  if (look.learnt) keep_what_was_learnt();
  if (watch_->has_landmarks()) publish(std::move(status));
}

// Logs once when a disagreement is established and once when it ends.
void VisibilityLoop::publish(VisibilityStatus status) {
  const bool disagrees = status.sky && status.sky->agreement == Agreement::disagrees;
  disagreements_ = disagrees ? disagreements_ + 1 : 0;
  if (disagreements_ >= kDisagreementsToReport && !reported_) spdlog::warn("visibility: {}", status.sky->message);
  if (!disagrees && reported_) spdlog::info("visibility: landmarks and sky agree again");
  reported_ = disagreements_ >= kDisagreementsToReport;
  status.finding = reported_;
  mailboxes_.status->visibility.put(std::move(status));
}

}  // namespace kasumi
