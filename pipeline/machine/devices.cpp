#include "pipeline/machine/devices.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include <spdlog/spdlog.h>

#include "gles/display/headless_display.hpp"
#include "pipeline/machine/mode_log.hpp"
#include "pipeline/machine/replay_camera.hpp"

namespace kasumi {

namespace {

// The two cameras of one recording play in sync, each in its own thread.
class Recordings {
 public:
  explicit Recordings(Clock& clock) : clock_(clock) {}

  Result<std::shared_ptr<ReplaySource>> open(const std::filesystem::path& fixture, CameraRole role) {
    const std::lock_guard lock(mutex_);
    auto both = opened_[fixture].lock();
    if (!both) {
      auto sources = open_fixture_sources(fixture, clock_, {.loop = true});
      if (!sources) return fail(sources.error());
      both = std::make_shared<FixtureSources>(std::move(*sources));
      opened_[fixture] = both;
    }
    auto* source = role == CameraRole::sky ? both->sky.get() : both->scene.get();
    return std::shared_ptr<ReplaySource>(std::move(both), source);
  }

 private:
  Clock& clock_;
  std::mutex mutex_;
  std::map<std::filesystem::path, std::weak_ptr<FixtureSources>> opened_;
};

Duration interval_of(const CameraRequest& request) {
  return request.frames_per_second > 0.0 ? from_seconds(1.0 / request.frames_per_second) : Duration{0};
}

class MachineDevices final : public Devices {
 public:
  explicit MachineDevices(Clock& clock) : clock_(clock), recordings_(clock) {}

  CameraOpening camera(CameraRole role, const CameraOptions& options) override {
    const std::string name = role == CameraRole::sky ? "sky camera" : "scene camera";
    return std::visit([&](const auto& chosen) { return opening(name, role, chosen); }, options);
  }

  Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) override {
    return std::visit([&](const auto& chosen) { return open(chosen); }, options);
  }

  std::unique_ptr<DisplayWatch> watch_displays() override {
    auto watch = kasumi::watch_displays();
    if (watch) return std::move(*watch);
    spdlog::info("display: {}: polling every second instead", watch.error().message);
    return nullptr;
  }

  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path& adapter) override {
    return open_cec_device(adapter);
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path& device) override {
    return open_input_device(device);
  }
  void serve(std::shared_ptr<InputLink> link) override { serve_input(std::move(link), open_input_device); }

 private:
  CameraOpening opening(const std::string& name, CameraRole role, const ReplayCamera& replay) {
    const auto folder = replay.fixture / (role == CameraRole::sky ? "sky" : "scene");
    const auto recording = [this, role, fixture = replay.fixture] { return recordings_.open(fixture, role); };
    return {replay_camera(name, recording, clock_), median_interval(folder), true};
  }
  CameraOpening opening(const std::string& name, CameraRole, const V4l2Options& options) {
    const auto open = [this, options, log = ModeLog(name)]() mutable { return log(open_v4l2_source(options, clock_)); };
    const auto present = [device = options.device] {
      std::error_code error;
      return std::filesystem::exists(device, error);
    };
    return {{name, open, present}, interval_of(options.request), false};
  }
  CameraOpening opening(const std::string& name, CameraRole, const LibcameraOptions& options) {
    const auto open = [this, options, log = ModeLog(name)]() mutable {
      return log(open_libcamera_source(options, clock_));
    };
    const auto present = [camera = options.camera] { return is_libcamera_camera_present(camera); };
    return {{name, open, present}, interval_of(options.request), false};
  }

  Result<std::unique_ptr<Display>> open(const KmsDisplayOptions& kms) { return open_kms_display(kms, clock_); }
  Result<std::unique_ptr<Display>> open(const WindowDisplayOptions& window) {
    return open_window_display(window, clock_);
  }
  Result<std::unique_ptr<Display>> open(const HeadlessDisplayOptions& headless) {
    auto display = open_headless_display(headless, clock_);
    if (!display) return fail(display.error());
    return std::move(*display);
  }

  Clock& clock_;
  Recordings recordings_;
};

}  // namespace

std::unique_ptr<ReconnectingSource> reconnecting(CameraOpening opening, Clock& clock) {
  ReconnectTimes options;
  const auto at_least = [](Duration& deadline, Duration least) { deadline = std::max(deadline, least); };
  at_least(options.stall_deadline, opening.frame_interval * 5 / 2);
  at_least(options.first_frame_deadline, opening.frame_interval * 5 / 2);
  at_least(options.bad_frames_deadline, opening.frame_interval * 5);
  at_least(options.condition_deadline, opening.frame_interval * 5);
  return reconnecting(std::move(opening.opener), clock, options);
}

std::unique_ptr<Devices> machine_devices(Clock& clock) {
  return std::make_unique<MachineDevices>(clock);
}

}  // namespace kasumi
