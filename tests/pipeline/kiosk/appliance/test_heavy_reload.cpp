// A reload of content that takes seconds to prepare, with the appliance's real threads and clock: the picture goes on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <numeric>
#include <string>
#include <thread>

#include <unistd.h>

#include "base/files.hpp"
#include "capture/fixture/fixture.hpp"
#include "fixtures/model/png.hpp"
#include "tests/gles/model/gltf_writer.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

constexpr Duration kCameraInterval = 33ms;
constexpr Duration kLongestStandstill = 250ms;
constexpr double kBusyMachine = .1;  // of the processors' time in other processes' hands

// The recording's first scene frame, thirty times a second, with something that moves: it is not frozen.
class SteadyCamera final : public FrameSource {
 public:
  SteadyCamera(Frame frame, Clock& clock)
      : frame_(std::move(frame)), payloads_{frame_.payload, moved(frame_.payload)}, clock_(clock), next_(clock.now()) {}
  std::string description() const override { return "steady camera"; }
  Result<Frame> next(Instant deadline) override {
    if (next_ > deadline) {
      clock_.sleep_until(deadline);
      return fail(FaultKind::timeout, "no frame yet");
    }
    clock_.sleep_until(next_);
    next_ = std::max(next_ + kCameraInterval, clock_.now());
    frame_.metadata.captured_at = clock_.now();
    frame_.payload = payloads_[++frame_.metadata.sequence % 2];
    return frame_;
  }

 private:
  static Payload moved(const Payload& payload) {
    std::vector<std::uint8_t> bytes(payload.bytes.begin(), payload.bytes.end());
    for (std::size_t i = 0; i < bytes.size() / 2; ++i) bytes[i] = static_cast<std::uint8_t>(bytes[i] / 2 + 40);
    return payload_of(std::move(bytes));
  }

  Frame frame_;
  std::array<Payload, 2> payloads_;
  Clock& clock_;
  Instant next_;
};

// Notes when pictures are shown.
class TimedDisplay final : public Display {
 public:
  TimedDisplay(std::unique_ptr<HeadlessDisplay> display, Clock& clock, std::vector<Instant>& shown)
      : display_(std::move(display)), clock_(clock), shown_(shown) {}
  std::string description() const override { return display_->description(); }
  GlContext& context() override { return display_->context(); }
  Result<DrawTarget> begin(Instant deadline) override { return display_->begin(deadline); }
  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced) override {
    auto number = display_->show(std::move(until_replaced));
    shown_.push_back(clock_.now());
    return number;
  }
  std::vector<Flip> take_flips() override { return display_->take_flips(); }

 private:
  std::unique_ptr<HeadlessDisplay> display_;
  Clock& clock_;
  std::vector<Instant>& shown_;
};

class TimedDevices final : public Devices {
 public:
  explicit TimedDevices(Clock& clock) : clock_(clock), machine_(machine_devices(clock)) {}
  CameraOpening camera(CameraRole role, const CameraOptions& options) override {
    if (role == CameraRole::sky) return machine_->camera(role, options);
    const auto row = read_index(bench_fixture() / "scene").value().front();
    const Frame frame{row.metadata, payload_of(read_file(bench_fixture() / "scene" / row.payload).value())};
    const auto open = [this, frame]() -> Result<std::unique_ptr<FrameSource>> {
      return std::make_unique<SteadyCamera>(frame, clock_);
    };
    return {{"scene camera", open, {}}, kCameraInterval, true};
  }
  Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) override {
    auto display = open_headless_display(std::get<HeadlessDisplayOptions>(options), clock_);
    if (!display) return fail(display.error());
    return std::make_unique<TimedDisplay>(std::move(*display), clock_, shown);
  }
  std::unique_ptr<DisplayWatch> watch_displays() override { return nullptr; }
  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path&) override {
    return fail(FaultKind::disconnected, "no television");
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path&) override {
    return fail(FaultKind::disconnected, "no input device");
  }
  void serve(std::shared_ptr<InputLink>) override {}

  std::vector<Instant> shown;

 private:
  Clock& clock_;
  std::unique_ptr<Devices> machine_;
};

// Eight walls, each with a picture of its own.
void write_heavy_model(const std::filesystem::path& file, int texels) {
  const std::vector<std::uint8_t> png = fixtures::png_of(Image<Rgb8>(texels, texels, Rgb8{150, 140, 120}));
  GltfFile model = square_file();
  nlohmann::json wall = model.primitive();
  wall["attributes"]["TEXCOORD_0"] = model.add_floats({0, 1, 1, 1, 1, 0, 0, 0}, 2);
  for (int i = 0; i < 8; ++i) {
    while (model.buffer.size() % 4 != 0) model.buffer.push_back(0);
    model.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", model.buffer.size()}, {"byteLength", png.size()}});
    model.buffer.insert(model.buffer.end(), png.begin(), png.end());
    model.json["images"].push_back({{"bufferView", model.json["bufferViews"].size() - 1}, {"mimeType", "image/png"}});
    model.json["textures"].push_back({{"source", i}});
    model.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
    wall["material"] = i;
    model.json["meshes"][std::size_t(i)]["primitives"] = {wall};
    model.json["nodes"][std::size_t(i)] = {{"mesh", i}, {"scale", {5, 15, 1}}, {"translation", {6 * i, 0, 5}}};
    model.json["scenes"][0]["nodes"][std::size_t(i)] = i;
  }
  ASSERT_TRUE(write_file(file, model.binary()));
}

// Processor time since boot, in ticks: what all processes and other machines on the same host took, and what this one did.
struct ProcessorTime {
  double all = 0, busy = 0, ours = 0;

  static ProcessorTime now() {
    ProcessorTime time;
    std::array<double, 8> spent{};  // user, nice, system, idle, waiting for disks, interrupts, soft ones, stolen
    std::ifstream stat("/proc/stat");
    std::string cpu;
    stat >> cpu;
    for (auto& ticks : spent) stat >> ticks;
    time.all = std::accumulate(spent.begin(), spent.end(), 0.0);
    time.busy = time.all - spent[3] - spent[4];
    time.ours = static_cast<double>(std::clock()) / CLOCKS_PER_SEC * static_cast<double>(::sysconf(_SC_CLK_TCK));
    return time;
  }
};

// The share of the processors that others had.
double share_of_others(const ProcessorTime& began, const ProcessorTime& ended) {
  return (ended.busy - began.busy - (ended.ours - began.ours)) / std::max(1.0, ended.all - began.all);
}

// The appliance with its real threads but the main one.
class Running {
 public:
  explicit Running(const std::filesystem::path& config)
      : devices(clock),
        appliance(config, read_content(config).value(), ApplianceServices{devices, clock, time_, notifier_},
                  StatusOutputs{std::nullopt, false, 1h}) {
    loops_.emplace_back([this] {
      while (!stop_) appliance.scene().step(clock.now() + 100ms);
    });
    loops_.emplace_back([this] {
      while (!stop_) appliance.sky().step(clock.now() + 100ms);
    });
    loops_.emplace_back([this] {
      while (!stop_) {
        const auto again = appliance.reload().step();
        appliance.reload_bell().wait_for(std::min<Duration>(again - clock.now(), 100ms));
      }
    });
  }
  ~Running() {
    stop_ = true;
    for (auto& loop : loops_) loop.join();
    appliance.render().finish();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  // The main thread's loop.
  void run_for(Duration time) {
    const auto until = clock.now() + time;
    while (clock.now() < until) {
      const auto again = appliance.render().step();
      appliance.render_bell().wait_for(std::min(again, until) - clock.now());
    }
  }
  const std::optional<ReloadStatus>& reload_status() {
    appliance.status().step();
    return appliance.status().status().reload;
  }
  // The longest time between two pictures since then.
  Duration longest_standstill(Instant since) const {
    Duration longest{};
    for (std::size_t i = 1; i < devices.shown.size(); ++i)
      if (devices.shown[i] >= since) longest = std::max(longest, devices.shown[i] - devices.shown[i - 1]);
    return longest;
  }

  SystemClock clock;
  TimedDevices devices;
  FakeTime time_;
  FakeNotifier notifier_;
  Appliance appliance;

 private:
  std::atomic<bool> stop_ = false;
  std::vector<std::thread> loops_;
};

// Whatever else the machine does only adds to it: the best of three reloads counts.
TEST(HeavyReload, Row36ThePictureNeverStandsStillForAQuarterOfASecond) {
  const auto folder = test_folder("heavy-reload");
  std::filesystem::remove_all(folder);
  const auto config = write_config(folder);
  write_heavy_model(folder / "heavy.glb", 4096);
  Running running(config);
  running.run_for(4s);
  ASSERT_EQ(running.appliance.render().rung().shown, Shown::live) << name_of(running.appliance.render().rung().trouble);
  ASSERT_TRUE(running.appliance.render().status().building_drawn);
  std::filesystem::rename(folder / "heavy.glb", folder / "temple.glb");

  Duration best = 1h;
  double least_others = 1;
  for (int i = 0; i < 3 && best > kLongestStandstill; ++i) {
    const auto quiet_from = running.clock.now();
    running.run_for(1s);
    const auto quiet = running.longest_standstill(quiet_from);
    const auto asked = running.clock.now();
    const auto began = ProcessorTime::now();
    running.appliance.reload().ask();
    const auto ended = [&] {
      const auto& status = running.reload_status();
      return status && status->began && *status->began >= asked && status->doing.empty();
    };
    while (!ended() && running.clock.now() - asked < 120s) running.run_for(50ms);
    const auto took = running.clock.now() - asked;
    ASSERT_TRUE(ended());
    ASSERT_TRUE(running.reload_status()->problems.empty()) << running.reload_status()->problems.front();
    running.run_for(1s);
    const auto standstill = running.longest_standstill(asked);
    const double others = share_of_others(began, ProcessorTime::now());
    std::printf(
        "36 reload of eight textures of 4096 x 4096 in %.1f s: the picture stood still for %.3f s at most, "
        "%.3f s before; other processes had %.0f %% of the machine\n",
        to_seconds(took), to_seconds(standstill), to_seconds(quiet), 100 * others);
    std::fflush(stdout);
    best = std::min(best, standstill);
    least_others = std::min(least_others, others);
  }
  if (best > kLongestStandstill && least_others > kBusyMachine)
    GTEST_SKIP() << fmt::format("the machine is too busy to tell: other processes had {:.0f} % of it",
                                100 * least_others);
  EXPECT_TRUE(running.appliance.render().status().building_drawn);
  EXPECT_LE(best, kLongestStandstill);
}

}  // namespace
}  // namespace kasumi
