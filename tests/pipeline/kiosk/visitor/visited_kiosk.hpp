// A kiosk with a visitor's panel of buttons: events of a fake device in, pictures of the glass out.
#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <linux/input-event-codes.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {

inline const std::filesystem::path kPanel = "/dev/input/by-id/usb-Panel-event-kbd";
inline constexpr const char* kHand =
    "\n[visitor]\ndevices = [\"/dev/input/by-id/usb-Panel-event-kbd\"]\nthen_and_now = [\"KEY_SPACE\"]\n"
    "era = [\"KEY_E\"]\nlanguage = [\"KEY_L\"]\nlarge_print = [\"KEY_P\"]\nstory = [\"KEY_S\"]\nview = [\"KEY_V\"]\n";

struct VisitedKiosk {
  explicit VisitedKiosk(const std::string& name, const std::string& more = {}, const std::string& first = {}) {
    rig = std::make_unique<Rig>(
        RigOptions{.name = name, .more_config = kHand + more, .first_config = first, .keep_folder = !first.empty()});
    plug();
    rig->advance(12s);
    EXPECT_EQ(rig->shown(), Shown::live);
  }
  void plug() {
    auto& is = rig->devices.input.devices[kPanel];
    is.plugged = true;
    is.axes[ABS_X].maximum = 1000;
  }
  FakeInputDevice& panel() { return rig->devices.input.devices[kPanel]; }
  void tap(int code) {
    panel().key(code, true);
    rig->advance(60ms);
    panel().key(code, false);
    rig->advance(60ms);
  }
  void touch(int place) {
    panel().send(EV_KEY, BTN_TOUCH, 1);
    panel().send(EV_ABS, ABS_X, place);
    panel().report();
    rig->advance(400ms);
  }
  void let_go() {
    panel().send(EV_KEY, BTN_TOUCH, 0);
    panel().report();
    rig->advance(40ms);
  }
  nlohmann::json status() {
    rig->status();
    return parse_json(read_text_file(rig->folder / "status.json").value());
  }
  std::unique_ptr<Rig> rig;
};

// Below the frame's number and above the labels.
inline double difference(const Image<Rgb8>& a, const Image<Rgb8>& b, int from, int to) {
  double sum = 0.0;
  for (int y = 20; y < 120; ++y)
    for (int x = from; x < to; ++x) sum += std::abs(a.at(x, y).g - b.at(x, y).g);
  return sum / (100.0 * (to - from));
}

// White letters of the note at the top.
inline int letters_at_the_top(const Image<Rgb8>& picture) {
  int count = 0;
  for (int y = 2; y < 26; ++y)
    for (int x = 100; x < 220; ++x) count += picture.at(x, y).g > 215 ? 1 : 0;
  return count;
}

// Two of the day, and one for visitors alone.
inline constexpr const char* kThreeEras =
    "[opening]\ntime_zone = \"UTC\"\n[[era]]\nname = \"temple\"\nhours = \"00:00-24:00\"\n"
    "[[era]]\nname = \"pagoda\"\nvisitors_only = true\nmodel = \"pagoda.glb\"\n"
    "[[era]]\nname = \"gate\"\nvisitors_only = true\nmodel = \"pagoda.glb\"\n";

inline RigOptions with_three_eras(const std::string& name) {
  const auto folder = test_folder("appliance-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(source_folder() / "fixtures/pagoda.glb", folder / "pagoda.glb");
  RigOptions options{.name = name, .more_config = std::string(kHand) + kThreeEras};
  options.keep_folder = true;
  return options;
}

}  // namespace kasumi
