#include "pipeline/install/calibrate/board_session.hpp"

#include <cstdio>

#include "calib/board/board_collector.hpp"
#include "capture/fixture/replay_source.hpp"
#include "pipeline/install/calibrate/board_window.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kPatience = 500ms;  // interval of the checks whether to stop
constexpr Duration kSayAgain = 1s;

Image<std::uint8_t> grey_of(const PictureView& picture) {
  Image<std::uint8_t> grey(picture.width, picture.height);
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x) {
      const auto p = rgb_at(picture, x, y);
      grey.at(x, y) = static_cast<std::uint8_t>((77 * p.r + 150 * p.g + 29 * p.b + 128) >> 8);
    }
  return grey;
}

// A recording behaves like a camera that does not reconnect.
class OwningReplay final : public FrameSource {
 public:
  OwningReplay(std::unique_ptr<FastForwardClock> clock, std::unique_ptr<ReplaySource> source)
      : clock_(std::move(clock)), source_(std::move(source)) {}
  std::string description() const override { return source_->description(); }
  Result<Frame> next(Instant) override { return source_->next(Instant::max()); }

 private:
  std::unique_ptr<FastForwardClock> clock_;
  std::unique_ptr<ReplaySource> source_;
};

// The opener refers to the devices, so both are kept alive together.
class OwningSource final : public FrameSource {
 public:
  OwningSource(std::unique_ptr<Devices> devices, std::unique_ptr<FrameSource> source)
      : devices_(std::move(devices)), source_(std::move(source)) {}
  std::string description() const override { return source_->description(); }
  Result<Frame> next(Instant deadline) override { return source_->next(deadline); }

 private:
  std::unique_ptr<Devices> devices_;
  std::unique_ptr<FrameSource> source_;
};

Result<std::unique_ptr<FrameSource>> open_recording(std::filesystem::path folder, const std::string& camera) {
  std::error_code error;
  if (!std::filesystem::exists(folder / "index.csv", error)) folder /= camera;
  auto clock = std::make_unique<FastForwardClock>(Utc{});
  auto source = open_replay(folder, *clock);
  if (!source) return fail(source.error());
  return std::make_unique<OwningReplay>(std::move(clock), std::move(*source));
}

}  // namespace

Result<GatheredViews> gather_views(FrameSource& source, const AnyBoard& board, Clock& clock,
                                   const BoardSessionControl& options) {
  std::optional<BoardWindow> window;
  if (options.window) {
    auto opened = BoardWindow::open();
    if (!opened) return fail(opened.error());
    window = std::move(*opened);
  }
  BoardCollector collector(board);
  GatheredViews gathered;
  const auto begun = clock.now();
  std::string said;
  std::optional<Instant> said_at;
  // Every view taken is reported; other messages are limited in rate.
  const auto say = [&](const std::string& message, bool always = false) {
    if (!always && (message == said || (said_at && clock.now() - *said_at < kSayAgain))) return;
    said = message;
    said_at = clock.now();
    if (options.say) options.say(message);
  };
  say(collector.advice());
  while (gathered.ended.empty()) {
    if (options.stop && options.stop()) gathered.ended = "stopped";
    if (options.longest > Duration{} && clock.now() - begun > options.longest) gathered.ended = "time limit reached";
    if (!gathered.ended.empty()) break;
    const auto frame = source.next(clock.now() + kPatience);
    if (!frame && frame.error().kind == FaultKind::end_of_stream) {
      gathered.ended = "end of the recording";
      break;
    }
    if (!frame && (frame.error().kind == FaultKind::timeout || frame.error().kind == FaultKind::disconnected)) {
      say("no picture from the camera");
      continue;
    }
    if (!frame) return fail(frame.error());
    const auto decoded = decode(*frame, YuvEncoding::bt601_full);
    if (!decoded) continue;
    const auto grey = grey_of(decoded->view());
    if (gathered.width == 0) {
      gathered.width = grey.width();
      gathered.height = grey.height();
    }
    if (grey.width() != gathered.width || grey.height() != gathered.height)
      return fail(FaultKind::bad_input, "{}: the picture size changed from {} x {} to {} x {}: expected one size",
                  source.description(), gathered.width, gathered.height, grey.width(), grey.height());
    ++gathered.frames;
    const auto found =
        collector.look(grey, fmt::format("view {} (frame {})", collector.views().size() + 1, frame->metadata.sequence));
    if (found == BoardCollector::Found::taken)
      say(fmt::format("view {} taken, {:.0f} % of the picture\n{}{}", collector.views().size(),
                      100.0 * collector.covered(), collector.map(), collector.advice()),
          true);
    else if (found == BoardCollector::Found::known || found == BoardCollector::Found::nothing)
      say(fmt::format("{}: {}", message_of(found), collector.advice()));
    else
      say(std::string(message_of(found)));
    if (window) {
      const auto open = window->show(grey, collector, fmt::format("{}: {}", message_of(found), collector.advice()));
      if (!open) return fail(open.error());
      if (!*open) gathered.ended = "stopped";
    }
    if (collector.enough()) gathered.ended = "the picture is covered";
  }
  gathered.views = collector.views();
  return gathered;
}

Result<std::unique_ptr<FrameSource>> open_live(const std::string& device_or_recording, const std::string& camera,
                                               const std::string& size, Clock& clock) {
  std::error_code error;
  if (std::filesystem::is_directory(device_or_recording, error)) return open_recording(device_or_recording, camera);
  V4l2Options options;
  options.device = device_or_recording;
  options.request.lend_buffers = false;
  char end = 0;
  if (std::sscanf(size.c_str(), "%dx%d%c", &options.request.width, &options.request.height, &end) != 2 ||
      options.request.width < 16 || options.request.height < 16)
    return fail(FaultKind::bad_input, "--size {}: expected the size of the camera's pictures, like 1920x1080",
                size.empty() ? "(none)" : size);
  auto source = open_v4l2_source(options, clock);
  if (!source) return fail(source.error());
  return std::move(*source);
}

Result<std::unique_ptr<FrameSource>> open_configured(const std::string& config, const std::string& camera,
                                                     Clock& clock) {
  const auto root = ConfigTable::read_file(config);
  if (!root) return fail(root.error());
  auto run = read_run_config(*root);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  auto& choice = camera == "sky" ? run.sky_camera : run.scene_camera;
  if (const auto* replay = std::get_if<ReplayCamera>(&choice)) return open_recording(replay->fixture, camera);
  std::visit(
      [](auto& chosen) {
        if constexpr (requires { chosen.request; }) chosen.request.lend_buffers = false;
      },
      choice);
  auto devices = machine_devices(clock);
  auto opening = devices->camera(camera == "sky" ? CameraRole::sky : CameraRole::scene, choice);
  auto source = reconnecting(std::move(opening), clock);
  return std::make_unique<OwningSource>(std::move(devices), std::move(source));
}

}  // namespace kasumi
