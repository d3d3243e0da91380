#include "pipeline/appliance/visibility_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/appliance/remembered_state.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kVisibilityPollInterval = 10s;  // for new content
constexpr Duration kReadingInterval = 1min;        // air changes in minutes
constexpr Duration kPictureWaitInterval = 200ms;   // for a requested picture
constexpr Duration kLearnInterval = 30min;         // until surfaces are lit differently
constexpr double kForgottenShare = 0.005;          // per reading, some twenty a day: a memory of ten days
constexpr int kDisagreementsToReport = 5;          // readings in a row: a lorry in front of a landmark has left by then
constexpr double kLowestSun = 0.087;               // sine of 5 degrees: below, land and horizon are lit differently

Image<glm::vec3> encoded_of(const Image<Rgb8>& picture) {
  Image<glm::vec3> encoded(picture.width(), picture.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    encoded.elements()[i] = glm::vec3(picture.elements()[i]) / 255.0F;
  return encoded;
}

}  // namespace

VisibilityLoop::VisibilityLoop(ContentPtr content, Clock& clock, Mailboxes& mailboxes)
    : content_(std::move(content)), clock_(clock), mailboxes_(mailboxes) {
  adopt_content();
}

void VisibilityLoop::adopt_content() {
  const auto& installation = content_->config.installation;
  watch_.reset();
  learnt_.reset();
  disagreements_ = 0;
  reported_ = false;
  if (installation.contrast_landmarks.empty()) return;
  watch_.emplace(installation.scene, installation.site.altitude_m, installation.contrast_landmarks);
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto resumed = resume(*watch_, *folder);
  if (!resumed)
    spdlog::warn("visibility: {}", resumed.error().message);
  else if (*resumed)
    learnt_ = clock_.now();  // the saved state may already include the present light
}

// Learns once per half hour, since the light hardly changes within it.
void VisibilityLoop::learn(const std::vector<ContrastReading>& readings) {
  const auto now = clock_.now();
  if (learnt_ && now - *learnt_ < kLearnInterval) return;
  learnt_ = now;
  watch_->forget(kForgottenShare);
  watch_->learn(readings);
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto saved = save(*watch_, *folder);
  if (!saved && !save_failing_) spdlog::warn("visibility: {}", saved.error().message);
  save_failing_ = !saved;
}

Instant VisibilityLoop::step() {
  if (const auto content = mailboxes_.visibility.content.take()) {
    content_ = *content;
    adopt_content();
    mailboxes_.status->visibility.put({});
  }
  const auto now = clock_.now();
  if (!watch_) return now + kVisibilityPollInterval;
  if (auto sky = mailboxes_.visibility.sky.take()) sky_ = *sky;
  if (const auto picture = mailboxes_.visibility.scene.take()) judge(*picture);
  if (now >= due_) {
    mailboxes_.scene.visibility_wants_picture = true;
    due_ = now + kReadingInterval;
  }
  return mailboxes_.scene.visibility_wants_picture ? now + kPictureWaitInterval : due_;
}

void VisibilityLoop::judge(const CheckPicture& picture) {
  const auto& installation = content_->config.installation;
  if (picture.picture.width() != installation.scene.width || picture.picture.height() != installation.scene.height)
    return;
  VisibilityStatus status{clock_.utc(), {}, {}, {}};
  if (sky_.sun && sky_.sun->z < kLowestSun) {
    status.reason = "the sun is too low: land and horizon are lit differently";
    return publish(std::move(status));
  }
  const auto readings = watch_->read(installation.scene, encoded_of(picture.picture));
  status.air = watch_->estimate(readings);
  status.reason = status.air->extinction().reason;
  if (sky_.turbidity) status.sky = watch_->compare(*status.air, sky_.turbidity->turbidity, sky_.turbidity->sigma);
  learn(readings);
  publish(std::move(status));
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
