#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/lab/recording/record.hpp"
#include "pipeline/machine/running_appliance.hpp"
#include "pipeline/machine/stop_signal.hpp"

namespace kasumi {

namespace {

struct RecordArguments {
  std::string config;
  std::string out;
  double seconds = 60.0;
  double every_s = 0.0;
  std::uint64_t bytes = RecordingLimits{}.most_bytes;
  std::uint64_t keep_free = RecordingLimits{}.keep_free;
};

void print(const char* name, const RecordedStream& camera) {
  const auto& health = camera.health;
  fmt::print("{}: {} rows; {} good frames, {} dropped by the driver", name, camera.rows, health.good_frames,
             health.sequence_gaps);
  if (health.skipped > 0) fmt::print(", {} skipped because the disk was slow", health.skipped);
  for (const auto& [reason, count] : health.bad_frames) fmt::print(", {} {}", count, reason);
  if (!health.up && !health.cause.empty()) fmt::print("; disconnected: {}", health.cause);
  fmt::print("\n");
}

Result<int> run(const RecordArguments& arguments) {
  // Cameras serve one program at a time.
  if (const auto running = find_running_appliance(kServiceStatusFile))
    return fail(
        FaultKind::bad_input,
        "the appliance is running (pid {}) and uses the cameras: sudo systemctl stop kasumi, record, sudo systemctl "
        "start kasumi",
        running->pid);
  RecordRequest request;
  request.config = arguments.config;
  request.folder = arguments.out;
  request.length = from_seconds(arguments.seconds);
  request.every = from_seconds(arguments.every_s);
  request.limits = {arguments.bytes, arguments.keep_free};
  SystemClock clock;
  const auto devices = machine_devices(clock);
  const auto summary = record(request, *devices, clock, stop_requested);
  if (!summary) return fail(summary.error());
  print("sky", summary->sky);
  print("scene", summary->scene);
  fmt::print("{:.1f} MB in {:.1f} s; stopped: {}\n", static_cast<double>(summary->bytes) / 1e6,
             to_seconds(summary->lasted), summary->ended);
  fmt::print("written: {} (kasumi replay {})\n", arguments.out, arguments.out);
  return summary->whole ? 0 : 1;
}

}  // namespace

void add_record_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("record", "Record both live cameras as a fixture, with a notice on the display");
  auto arguments = std::make_shared<RecordArguments>();
  command->add_option("--config", arguments->config, "kasumi.toml")->required();
  command->add_option("--out", arguments->out, "A new folder")->required();
  command->add_option("--seconds", arguments->seconds, "How long; 0: until interrupted")
      ->check(CLI::Range(0.0, 366.0 * 86400.0))
      ->capture_default_str();
  command->add_option("--bytes", arguments->bytes, "Size limit")->capture_default_str();
  command->add_option("--every", arguments->every_s, "Keep a frame of each camera every S seconds; 0: every frame")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command->add_option("--keep-free", arguments->keep_free, "Bytes of the disk to keep free")->capture_default_str();
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace kasumi
