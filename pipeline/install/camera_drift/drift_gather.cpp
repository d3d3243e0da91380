#include "pipeline/install/camera_drift/drift_gather.hpp"

#include <thread>

#include "capture/reconnecting_source.hpp"
#include "pipeline/machine/progress.hpp"

namespace kasumi {
namespace {

// Short, so that both cameras are asked by turns.
constexpr Duration kFrameTimeout = std::chrono::milliseconds(200);

// Keeps one camera streaming and keeps a picture of it now and then.
void watch(CameraOpening opening, const Camera& camera, Clock& clock, Instant until, Duration apart,
           const std::function<bool()>& stop, const std::function<void(const Frame&, const PictureView&)>& keep) {
  const auto source = reconnecting(std::move(opening), clock);
  auto due = clock.now();
  while (clock.now() < until && !stop()) {
    const auto frame = source->next(std::min(until, clock.now() + kFrameTimeout));
    if (!frame || frame->metadata.status != FrameStatus::good || clock.now() < due) continue;
    const auto decoded = decode(*frame, camera.yuv_encoding);
    if (!decoded) continue;
    keep(*frame, decoded->view());
    due += apart;
  }
}

}  // namespace

Result<DriftFrames> gather_recorded(const Fixture& fixture) {
  DriftFrames frames(fixture.installation);
  const FrameSelection options{.most = kMostCheckFrames};
  const auto scene = for_each_picture(fixture, fixture.installation.scene, options,
                                      [&](const PictureView& view, const FrameMetadata&) { frames.add_scene(view); });
  if (!scene) return fail(scene.error());
  const auto sky = for_each_picture(
      fixture, fixture.installation.sky, options,
      [&](const PictureView& view, const FrameMetadata& metadata) { frames.add_sky(view, metadata, metadata.utc); });
  if (!sky) return fail(sky.error());
  return frames;
}

Result<DriftFrames> gather_live(const RunConfig& config, Devices& devices, Clock& clock, Duration length,
                                bool time_known, const std::function<bool()>& stop) {
  DriftFrames frames(config.installation);
  const auto until = clock.now() + length;
  const auto apart = length / kMostCheckFrames;
  auto sky = devices.camera(CameraRole::sky, config.sky_camera);
  const bool recorded = sky.recorded;
  Progress progress("pictures", static_cast<std::size_t>(kMostCheckFrames));
  // The threads write to different members of `frames`.
  std::thread other([&] {
    watch(std::move(sky), config.installation.sky, clock, until, apart, stop,
          [&](const Frame& frame, const PictureView& view) {
            const bool known = time_known || recorded;
            frames.add_sky(view, frame.metadata, known ? std::optional(frame.metadata.utc) : std::nullopt);
          });
  });
  watch(devices.camera(CameraRole::scene, config.scene_camera), config.installation.scene, clock, until, apart, stop,
        [&](const Frame&, const PictureView& view) {
          frames.add_scene(view);
          progress.advance("");
        });
  other.join();
  return frames;
}

}  // namespace kasumi
