// A kiosk in safe mode on the bench.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/appliance/safe_mode.hpp"
#include "pipeline/kiosk/start/safe_content.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {

struct SafeRig {
  explicit SafeRig(const std::string& name, StartMode mode = StartMode::safe)
      : folder(test_folder("safe-" + name)), clock(Utc{}), devices(clock) {
    std::filesystem::remove_all(folder);
    config = write_config(folder);
    for (int boot = 0; boot < 3 + (mode == StartMode::plain); ++boot)
      StartLog({folder / "state", {}}, std::to_string(boot), 15.0).doing("opening cameras and display");
    starts = std::make_unique<StartLog>(ServiceFolders{folder / "state", {}}, "now", 15.0);
    EXPECT_EQ(starts->mode(), mode);
  }
  void start() {
    safe = std::make_unique<SafeMode>(read_safe_content([this] { return config; }, starts->mode()), devices, clock,
                                      notifier, *starts, folder / "status.json");
  }
  void advance(Duration by) {
    for (const auto end = clock.now() + by; clock.now() < end; clock.advance(20ms)) safe->step();
  }
  std::optional<Rgb8> corner() {
    if (!safe->display()) return std::nullopt;
    const auto seen = read_picture(*safe->display());
    return seen ? std::optional(seen->at(2, 2)) : std::nullopt;
  }
  nlohmann::json status() const { return parse_json(read_text_file(folder / "status.json").value()); }

  std::filesystem::path folder, config;
  ManualClock clock;
  BenchDevices devices;
  FakeNotifier notifier;
  std::unique_ptr<StartLog> starts;
  std::unique_ptr<SafeMode> safe;
};

}  // namespace kasumi
