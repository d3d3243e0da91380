// A kiosk on the bench: real loops and drawing, a recording for the cameras, faults on demand and a manual clock. One
// thread does everything, so that tests are deterministic; only a loop whose camera hangs has one of its own.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/picture.hpp"
#include "pipeline/kiosk/appliance/appliance.hpp"
#include "tests/pipeline/kiosk/appliance/faulty_display.hpp"
#include "tests/pipeline/kiosk/appliance/faulty_source.hpp"
#include "tests/pipeline/machine/fake_input.hpp"
#include "tests/pipeline/machine/fake_television.hpp"

namespace kasumi {

using namespace std::chrono_literals;

// A recording of a clear noon whose scene frames carry their number in their corner, 0.2 s apart; made once.
constexpr Duration kSceneInterval = 200ms;
constexpr int kSceneFrames = 60;
const std::filesystem::path& bench_fixture();
// The number in the corner of a picture; empty when there is none.
std::optional<int> frame_number(const Image<Rgb8>& picture);

// kasumi.toml for that recording or another, on a screen of its scene's size, in `folder`, with a still picture in
// magenta.
std::filesystem::path write_config(const std::filesystem::path& folder, const std::string& clock_policy = "trusted",
                                   const std::filesystem::path& recording = bench_fixture());

class FakeTime final : public TimeWatch {
 public:
  ClockState read() override { return state; }
  ClockState state;
};

struct FakeNotifier final : Notifier {
  void ready() override { ++readies; }
  void status(const std::string& line) override { lines.push_back(line); }
  void alive() override { ++alives; }
  void extend_start(Duration) override { ++extensions; }
  void reloading() override { ++reloads; }
  void stopping() override {}
  int readies = 0, alives = 0, extensions = 0, reloads = 0;
  std::vector<std::string> lines;
};

class BenchDevices final : public Devices {
 public:
  explicit BenchDevices(Clock& clock) : clock_(clock), machine_(machine_devices(clock)) {}
  CameraOpening camera(CameraRole role, const CameraOptions& options) override;
  Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) override;
  std::unique_ptr<DisplayWatch> watch_displays() override { return watch_faulty_display(display); }
  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path&) override {
    return open_fake_television(television);
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path& device) override {
    return open_fake_input(input, device);
  }
  // Its turn comes with each tick of the rig; a driver that may hang has a thread of its own.
  void serve(std::shared_ptr<InputLink> link) override;
  void turn_inputs();
  ~BenchDevices() override;
  CameraFaults sky, scene;
  FakeTelevision television;
  FakeInput input;
  DisplayFaults display;

 private:
  Clock& clock_;
  std::unique_ptr<Devices> machine_;
  struct Served {
    Served(std::shared_ptr<InputLink> of, InputReader::Opener open, Clock& clock)
        : link(std::move(of)), reader(link->options(), std::move(open), clock) {}
    std::shared_ptr<InputLink> link;
    InputReader reader;
    std::atomic<bool> in_turn = false;
    std::thread stuck{};
  };
  std::vector<std::unique_ptr<Served>> inputs_;
};

// Of sky and horizon, over a long time in which the picture counts and the air does not.
constexpr Duration kSeldom = 1min;
inline ObservationPlan observing_seldom() {
  ObservationPlan sky;
  sky.observe_every = kSeldom;
  return sky;
}

struct RigOptions {
  std::string name = "rig";  // of its folder
  std::string clock_policy = "trusted";
  std::filesystem::path recording{};  // instead of the bench's; its frames carry no numbers
  std::string more_config{};          // at the end of kasumi.toml
  std::string first_config{};         // at its beginning
  bool no_leaves = false;             // what the scene's mask leaves open in part is free
  std::optional<Utc> utc{};           // the machine's time at the start; empty: the recording's
  ObservationPlan sky{};
  // How often sky and horizon are observed, which is most of an appliance's work; a kiosk does so every second.
  Duration observe_every = 5s;
  bool keep_folder = false;   // keep what an earlier rig of that name left on disk
  bool keep_content = false;  // and its configuration and content, to the time stamp
  DisplayFaults display{};
  ReloadLoop::Probes probes{};
  StartLog* starts = nullptr;
};

class Rig {
 public:
  static constexpr Duration kTick = 20ms;
  explicit Rig(RigOptions options = {});
  ~Rig();

  // Advances the clock step by step and runs every loop that is due.
  void advance(Duration by, Duration step = kTick);
  // The same until `condition` holds, for at most `longest`. Returns how long it took; empty: it never held.
  template <class Condition>
  std::optional<Duration> advance_until(Condition condition, Duration longest) {
    const auto began = clock.now();
    while (!condition()) {
      if (clock.now() - began >= longest) return std::nullopt;
      advance(kTick);
    }
    return clock.now() - began;
  }
  // Advances until the picture is live again; prints the time it took.
  std::optional<Duration> recover(const std::string& fault, Duration longest);

  Shown shown() const { return appliance->render().rung().shown; }
  Trouble trouble() const { return appliance->render().rung().trouble; }
  // The status as operators read it, at most half a second old.
  const Status& status() const {
    appliance->status().step();
    return appliance->status().status();
  }
  Image<Rgb8> picture();
  bool shows_still();
  // Age of the scene on the screen; empty when the screen shows something else.
  std::optional<Duration> age_on_screen();

  // Lets a camera's call return.
  void let_go(CameraFaults& camera);

  void hang_up() { appliance->reload().ask(); }  // SIGHUP

  std::filesystem::path folder, config;
  ManualClock clock;
  FakeTime time;
  FakeNotifier notifier;
  BenchDevices devices;
  std::unique_ptr<Devices> rested;  // as the program opens them
  std::unique_ptr<Appliance> appliance;
  bool render_hangs = false;

 private:
  void tick(Duration by);
  // One turn of a camera's loop. Once its camera's trap is set, in a thread of its own, which the rig leaves behind.
  void turn(CameraFaults& camera, std::thread& stuck, const std::function<void()>& step);
  std::thread stuck_scene_, stuck_sky_;
  std::optional<Instant> told_, horizon_at_;
  std::vector<std::optional<Instant>> given_at_;  // by frame number: when the camera last delivered it
  Duration observe_every_{};
};

// Replaces `from` in a text file, which must contain it.
void replace_in(const std::filesystem::path& file, const std::string& from, const std::string& to);

// Puts a file there that opens, but that no read of can succeed (EIO), as on a bad sector.
void make_unreadable(const std::filesystem::path& file);

// A landmark in the bench's pictures, for kasumi.toml.
constexpr const char* kAWood = "\n[[landmarks]]\nname = \"wood\"\ndistance_m = 3000\nregion_px = [20, 150, 40, 10]\n";

// A rig whose picture is live under a known air.
std::unique_ptr<Rig> running(RigOptions options);

}  // namespace kasumi
