// A kiosk on the bench that shows content in generations, on a clock that the test turns.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"

namespace kasumi {

inline constexpr Duration kStep = 5s;  // of a long time

// The whole appliance, on a recording.
struct KioskRig : Rig {
  explicit KioskRig(const std::string& name, const std::string& more = {})
      : Rig({.name = name, .observe_every = kSeldom}), desk(folder / "bundles"), generations(folder / "content") {
    std::filesystem::create_directories(desk);
    place = {write_desk(folder / "etc", more), generations};
  }
  void start() {
    const auto content = read_content(place.configuration());
    ASSERT_TRUE(content) << content.error().message;
    appliance = std::make_unique<Appliance>(place, *content, ApplianceServices{devices, clock, time, notifier},
                                            StatusOutputs{folder / "status.json", false, 10s, nullptr, folder / "sys"},
                                            observing_seldom());
  }
  void install(const std::string& name, const std::string& from, const std::string& to) {
    const auto made = write_desk(desk / name);
    if (!from.empty()) replace_in(made, from, to);
    const auto done = install_file(packed(made, name, clock.utc()), generations, clock.utc());
    ASSERT_TRUE(done) << done.error().message;
  }
  void pass(Duration by, Duration step = 1s) {
    for (const auto end = clock.now() + by; clock.now() < end;) {
      advance(step, step);
      appliance->proving().step();
    }
  }
  std::string status() {
    appliance->status().step();
    return status_json(appliance->status().status());
  }
  nlohmann::json content() { return parse_json(status())["content"]; }
  std::filesystem::path desk;
  Generations generations;
  ContentPlace place;
};

}  // namespace kasumi
