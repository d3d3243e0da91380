#include "pipeline/appliance/scene_loop.hpp"

#include "pipeline/appliance/status_mail.hpp"

namespace kasumi {

namespace {

constexpr Duration kTellSceneInterval = std::chrono::milliseconds(500);

}  // namespace

SceneLoop::SceneLoop(ContentPtr content, Devices& devices, Clock& clock, Exchange& exchange)
    : content_(std::move(content)),
      devices_(devices),
      clock_(clock),
      exchange_(exchange),
      camera_(devices.camera(CameraRole::scene, content_->config.scene_camera), clock) {}

void SceneLoop::step(Instant deadline) {
  take_content();
  auto frame = camera_.next(deadline);
  if (frame && frame->metadata.status == FrameStatus::good) {
    hand_on(std::move(*frame));
  } else if (!frame && frame.error().kind == FaultKind::disconnected) {
    exchange_.render.frames.take();  // a lent frame nobody fetched keeps the device open
  }
  tell();
}

// JPEGs are decoded here, so that drawing does not wait for it.
void SceneLoop::hand_on(Frame frame) {
  const auto& scene = content_->config.installation.scene;
  const auto& metadata = frame.metadata;
  if (metadata.width != scene.width || metadata.height != scene.height)
    return camera_.reject(
        fmt::format("{}x{} instead of {}x{}", metadata.width, metadata.height, scene.width, scene.height));
  auto picture = decode(frame, scene.yuv_encoding);
  if (!picture) return camera_.reject("damaged");
  if (exchange_.scene.check_wants_picture.exchange(false))
    exchange_.check.scene.put({metadata, to_rgb(picture->view()), false});
  if (exchange_.scene.visibility_wants_picture.exchange(false))
    exchange_.visibility.scene.put({metadata, to_rgb(picture->view()), false});
  exchange_.render.frames.put({metadata, std::move(*picture), frame.payload.holder, camera_.outages()});
  exchange_.render.bell.ring();
}

void SceneLoop::take_content() {
  const auto content = exchange_.scene.content.take();
  if (!content) return;
  const bool other_camera = (*content)->config.scene_camera != content_->config.scene_camera;
  content_ = *content;
  if (!other_camera) return;
  exchange_.render.frames.take();
  camera_.replace(devices_.camera(CameraRole::scene, content_->config.scene_camera));
}

void SceneLoop::tell() {
  auto news = camera_.news();
  const bool changed = news.outages != told_outages_ || news.health.condition != told_condition_;
  if (!changed && told_ && clock_.now() - *told_ < kTellSceneInterval) return;
  told_ = clock_.now();
  told_outages_ = news.outages;
  told_condition_ = news.health.condition;
  exchange_.status->scene_camera.put(news);
  exchange_.render.scene_camera.put(std::move(news));
  if (changed) exchange_.render.bell.ring();
}

}  // namespace kasumi
