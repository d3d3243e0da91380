#include <CLI/CLI.hpp>

#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/camera_drift/drift.hpp"
#include "pipeline/install/camera_drift/drift_gather.hpp"
#include "pipeline/install/camera_drift/drift_json.hpp"
#include "pipeline/machine/running_appliance.hpp"
#include "pipeline/machine/stop_signal.hpp"
#include "pipeline/machine/time_watch.hpp"

namespace kasumi {

namespace {

struct CheckArguments {
  std::string recording;
  std::string config;
  std::string calibration;
  double minutes = 10.0;
  bool reference = false;
  bool json = false;
};

struct CheckedFrames {
  DriftFrames frames;
  Installation installation;
  std::filesystem::path stem;
  Utc now{};
};

Result<CheckedFrames> gather_recording(const CheckArguments& arguments) {
  const auto fixture = read_fixture(arguments.recording);
  if (!fixture) return fail(fixture.error());
  auto frames = gather_recorded(*fixture);
  if (!frames) return fail(frames.error());
  const auto stem = reference_stem(fixture->installation, fixture->folder / "fixture.toml");
  return CheckedFrames{std::move(*frames), fixture->installation, stem, fixture->info.start_utc};
}

Result<CheckedFrames> gather_cameras(const CheckArguments& arguments) {
  const auto root = ConfigTable::read_file(arguments.config);
  if (!root) return fail(root.error());
  const auto config = read_run_config(*root);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  if (const auto running = find_running_appliance(kServiceStatusFile))
    return fail(
        FaultKind::bad_input,
        "the appliance is running (pid {}) and holds the cameras: its own check is in its status (kasumi doctor); "
        "or sudo systemctl stop kasumi, check, sudo systemctl start kasumi",
        running->pid);
  SystemClock clock;
  const auto devices = machine_devices(clock);
  TimeTrust trust(config.clock);
  const bool time_known = trust.judge(watch_time()->read(), clock.utc()) == SunSource::ephemeris;
  if (!arguments.json) fmt::print("watching the cameras for {:.1f} minutes\n", arguments.minutes);
  auto frames =
      gather_live(config, *devices, clock, from_seconds(60.0 * arguments.minutes), time_known, stop_requested);
  if (!frames) return fail(frames.error());
  const auto stem = reference_stem(config.installation, arguments.config);
  return CheckedFrames{std::move(*frames), config.installation, stem, clock.utc()};
}

// Without this check a missing file would get a new reference beside it, so a wrong path would pass.
Result<> find_calibration(const std::string& file) {
  if (file.empty()) return {};
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(FaultKind::bad_input, "--calibration {}: expected a calibration file", root.error().message);
  if (root->has("sky") || root->has("scene")) return {};
  return fail(FaultKind::bad_input, "--calibration {}: expected a calibration file, with [sky] or [scene]", file);
}

Result<int> check(const CheckArguments& arguments) {
  if (arguments.recording.empty() == arguments.config.empty())
    return fail(FaultKind::bad_input, "expected a RECORDING, or --config kasumi.toml for the live cameras");
  if (auto there = find_calibration(arguments.calibration); !there) return fail(there.error());
  auto checked = arguments.config.empty() ? gather_recording(arguments) : gather_cameras(arguments);
  if (!checked) return fail(checked.error());
  if (!arguments.calibration.empty()) checked->stem = std::filesystem::path(arguments.calibration).replace_extension();

  const auto take = [&](const std::string& why) -> Result<int> {
    const auto taken = take_reference(checked->frames, checked->installation, checked->now);
    if (!taken) return fail(taken.error());
    if (auto saved = save_reference(*taken, checked->stem); !saved) return fail(saved.error());
    fmt::print(stderr, "{}{}.check.json: saved as the reference for later checks\n", why, checked->stem.string());
    return 0;
  };
  if (arguments.reference) return take("");
  if (auto replaced = replace_kept_pictures(checked->stem, checked->installation); !replaced)
    return fail(replaced.error());
  const auto reference = load_reference(checked->stem, checked->installation);
  if (!reference && reference.error().kind == FaultKind::bad_input) return fail(reference.error());
  if (!reference) return take("there was no reference yet\n");
  if (!belongs_to(*reference, checked->installation))
    return take("the previous reference belongs to another calibration of the cameras\n");

  const auto report = find_drift(checked->frames, *reference, checked->installation, checked->now);
  fmt::print("{}", arguments.json ? drift_json(report) : drift_text(report) + drift_summary(report) + "\n");
  return report.steady() ? 0 : 1;
}

}  // namespace

void add_calibrate_check(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand("check",
                                                   "What has changed since calibration: camera bumped, out of focus, "
                                                   "fogged, dirty dome (exit code 1: something has)");
  auto arguments = std::make_shared<CheckArguments>();
  auto& a = *arguments;
  command->add_option("recording", a.recording, "A recording of both cameras, a few minutes of daylight");
  command->add_option("--config", a.config, "kasumi.toml: use the live cameras instead");
  command->add_option("--minutes", a.minutes, "How long to watch the live cameras")
      ->check(CLI::Range(0.01, 600.0))
      ->capture_default_str();
  command->add_option("--calibration", a.calibration,
                      "The calibration file whose reference is used (default: the one named where the "
                      "cameras are described, else next to that description)");
  command->add_flag(
      "--reference", a.reference,
      "Save the current state as the reference, from pictures over --minutes (the first check does so by itself)");
  command->add_flag("--json", a.json, "One JSON object");
  command->callback([arguments, &action] { action = [arguments] { return check(*arguments); }; });
}

}  // namespace kasumi
