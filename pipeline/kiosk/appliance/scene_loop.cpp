#include "pipeline/kiosk/appliance/scene_loop.hpp"

#include <utility>

#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/machine/camera_acceptance.hpp"

namespace kasumi {

namespace {

// Bounds how old the camera's status is while no frame comes.
constexpr Duration kSceneStatusInterval = std::chrono::milliseconds(500);

}  // namespace

SceneLoop::SceneLoop(ContentPtr content, Devices& devices, Clock& clock, Mailboxes& mailboxes)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      mailboxes_(mailboxes),
      camera_(devices.camera(CameraRole::scene, content_->config.scene_camera), clock) {}

void SceneLoop::step(Instant deadline) {
  mailboxes_.scene.pulse.turn(clock_.now(), deadline - clock_.now() + kWaitingBound);
  adopt_content();
  auto frame = camera_.next(deadline);
  if (frame && frame->metadata.status == FrameStatus::good) {
    forward(std::move(*frame));
  } else if (!frame && frame.error().kind == FaultKind::disconnected) {
    mailboxes_.render.frames.take();  // an unfetched frame would keep the device open
  }
  publish();
}

// JPEGs are decoded here, so that drawing does not wait for them.
void SceneLoop::forward(Frame frame) {
  const auto& scene = content_->config.installation.scene;
  const auto& metadata = frame.metadata;
  if (const auto why = why_unusable(metadata, scene); !why.empty()) return camera_.reject(why);
  if (is_spared()) return;
  auto picture = decode(frame, scene.yuv_encoding);
  if (!picture) return camera_.reject("damaged");
  ++mailboxes_.proving.scene_frames;
  if (mailboxes_.scene.check_wants_picture.exchange(false))
    mailboxes_.check.scene.put({metadata, to_rgb(picture->view()), false});
  // Of a covered or frozen camera landmarks would say what is not so.
  const bool sees = camera_.health().condition == PictureCondition::normal;
  if (sees && mailboxes_.scene.visibility_wants_picture.exchange(false))
    mailboxes_.visibility.scene.put({metadata, to_rgb(picture->view()), false});
  mailboxes_.render.frames.put({metadata, std::move(*picture), frame.payload.holder, camera_.outages()});
  mailboxes_.render.bell.ring();
}

// Of a machine that is too hot. The picture never becomes so old that it would be called held.
bool SceneLoop::is_spared() {
  const auto now = clock_.now();
  const auto interval = now - std::exchange(arrived_at_, now);
  const auto late = patient_with(content_->config.ladder, camera_.frame_interval()).late;
  if (++spared_ < mailboxes_.scene.show_one_of && now - forwarded_at_ + interval < late) {
    ++mailboxes_.scene.spared;
    return true;
  }
  spared_ = 0;
  forwarded_at_ = now;
  return false;
}

void SceneLoop::adopt_content() {
  const auto content = mailboxes_.scene.content.take();
  if (!content) return;
  const bool other_camera = (*content)->config.scene_camera != content_->config.scene_camera;
  content_ = *content;
  if (!other_camera) return;
  mailboxes_.render.frames.take();
  camera_.replace(devices_.camera(CameraRole::scene, content_->config.scene_camera));
}

void SceneLoop::publish() {
  auto status = camera_.status();
  const bool changed = status.outages != published_outages_ || status.health.condition != published_condition_;
  if (!changed && published_at_ && clock_.now() - *published_at_ < kSceneStatusInterval) return;
  published_at_ = clock_.now();
  published_outages_ = status.outages;
  published_condition_ = status.health.condition;
  mailboxes_.status->scene_camera.put(status);
  mailboxes_.render.scene_camera.put(std::move(status));
  if (changed) mailboxes_.render.bell.ring();
}

}  // namespace kasumi
