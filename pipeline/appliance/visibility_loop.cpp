#include "pipeline/appliance/visibility_loop.hpp"

#include <spdlog/spdlog.h>

#include "pipeline/appliance/remembered_state.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLookForContent = 10s;  // for other content
constexpr Duration kInterval = 1min;       // air changes in minutes
constexpr Duration kWaiting = 200ms;       // for a picture that was asked for
constexpr Duration kLearning = 30min;      // until surfaces are lit otherwise
constexpr double kForgetting = 0.005;      // with each that is learnt, some twenty a day: ten days, seasons are longer
constexpr int kApart = 5;                  // looks: a lorry before a landmark is gone by then
constexpr double kLowestSun = 0.087;       // sine of 5 degrees: below, the land lies in other light than the horizon

Image<glm::vec3> encoded_of(const Image<Rgb8>& picture) {
  Image<glm::vec3> encoded(picture.width(), picture.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    encoded.elements()[i] = glm::vec3(picture.elements()[i]) / 255.0F;
  return encoded;
}

}  // namespace

VisibilityLoop::VisibilityLoop(ContentPtr content, Clock& clock, Exchange& exchange)
    : content_(std::move(content)), clock_(clock), exchange_(exchange) {
  take_content();
}

void VisibilityLoop::take_content() {
  const auto& installation = content_->config.installation;
  watch_.reset();
  learnt_.reset();
  apart_ = 0;
  told_ = false;
  if (installation.contrast_landmarks.empty()) return;
  watch_.emplace(installation.scene, installation.site.altitude_m, installation.contrast_landmarks);
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto resumed = resume(*watch_, *folder);
  if (!resumed)
    spdlog::warn("visibility: {}", resumed.error().message);
  else if (*resumed)
    learnt_ = clock_.now();  // perhaps in this very light
}

// The light of one half hour is learnt once.
void VisibilityLoop::learn(const std::vector<ContrastReading>& readings) {
  const auto now = clock_.now();
  if (learnt_ && now - *learnt_ < kLearning) return;
  learnt_ = now;
  watch_->forget(kForgetting);
  watch_->learn(readings);
  const auto& folder = content_->config.state_folder;
  if (!folder) return;
  const auto saved = save(*watch_, *folder);
  if (!saved && !unsaved_) spdlog::warn("visibility: {}", saved.error().message);
  unsaved_ = !saved;
}

Instant VisibilityLoop::step() {
  if (const auto content = exchange_.visibility.content.take()) {
    content_ = *content;
    take_content();
    exchange_.status->visibility.put({});
  }
  const auto now = clock_.now();
  if (!watch_) return now + kLookForContent;
  if (auto sky = exchange_.visibility.sky.take()) sky_ = *sky;
  if (const auto picture = exchange_.visibility.scene.take()) judge(*picture);
  if (now >= due_) {
    exchange_.scene.visibility_wants_picture = true;
    due_ = now + kInterval;
  }
  return exchange_.scene.visibility_wants_picture ? now + kWaiting : due_;
}

void VisibilityLoop::judge(const CheckPicture& picture) {
  const auto& installation = content_->config.installation;
  if (picture.picture.width() != installation.scene.width || picture.picture.height() != installation.scene.height)
    return;
  VisibilityNews news{clock_.utc(), {}, {}, {}};
  if (sky_.sun && sky_.sun->z < kLowestSun) {
    news.reason = "the sun is too low: land and horizon do not share their light";
    return tell(std::move(news));
  }
  const auto readings = watch_->read(installation.scene, encoded_of(picture.picture));
  news.air = watch_->estimate(readings);
  news.reason = news.air->extinction().reason;
  if (sky_.turbidity) news.sky = watch_->compare(*news.air, sky_.turbidity->turbidity, sky_.turbidity->sigma);
  learn(readings);
  tell(std::move(news));
}

// One line when it begins, one when it ends.
void VisibilityLoop::tell(VisibilityNews news) {
  const bool apart = news.sky && news.sky->agreement == Agreement::disagrees;
  apart_ = apart ? apart_ + 1 : 0;
  if (apart_ >= kApart && !told_) spdlog::warn("visibility: {}", news.sky->message);
  if (!apart && told_) spdlog::info("visibility: landmarks and sky are not apart any more");
  told_ = apart_ >= kApart;
  news.finding = told_;
  exchange_.status->visibility.put(std::move(news));
}

}  // namespace kasumi
