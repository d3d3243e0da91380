// kasumi.toml: one kiosk and how it runs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "base/table/config_table.hpp"
#include "capture/libcamera/libcamera_source.hpp"
#include "capture/v4l2/v4l2_source.hpp"
#include "gles/display/display.hpp"
#include "gles/scene.hpp"
#include "pipeline/site/config/eras.hpp"
#include "pipeline/site/config/heat_governor.hpp"
#include "pipeline/site/config/installation.hpp"
#include "pipeline/site/config/ladder.hpp"
#include "pipeline/site/config/messages.hpp"
#include "pipeline/site/config/opening_hours.hpp"
#include "pipeline/site/config/time_trust.hpp"
#include "pipeline/site/visitor/visitor_options.hpp"

namespace kasumi {

struct ReplayCamera {
  std::filesystem::path fixture;  // played in a loop
  friend bool operator==(const ReplayCamera&, const ReplayCamera&) = default;
};
using CameraOptions = std::variant<V4l2Options, LibcameraOptions, ReplayCamera>;
using DisplayOptions = std::variant<KmsDisplayOptions, WindowDisplayOptions, HeadlessDisplayOptions>;

struct StillContent {
  std::optional<std::filesystem::path> picture;  // empty: a plain background
  std::string caption;
};
struct MessageStyle {
  Language language = Language::english;
  std::optional<std::filesystem::path> font_file;
  double print = 1.0;          // of the letters' usual size
  bool plain_letters = false;  // those of the program itself: no font is read
  bool show_faults = true;     // false: visitors see only the caption of the still picture
};

// The daily check of the cameras against their calibration.
struct CheckSchedule {
  std::optional<OpeningHours> hours;  // when pictures are gathered for it; empty: never
  Duration length{};                  // of that time
};

// What of the screen may leave the kiosk, besides what `kasumi snapshot` always gives its own account.
struct SnapshotPermission {
  bool sharp = false;           // to `kasumi snapshot`: pictures in which people can be recognised
  bool screen_picture = false;  // to kasumi-report: blurred ones, at most one a minute
};

struct RunConfig {
  Installation installation;   // its sky_model is never preetham
  std::string sky_model_note;  // for people: what is followed instead of the configured one; empty: that is
  CameraOptions sky_camera;
  CameraOptions scene_camera;
  DisplayOptions display;
  bool planes = true;  // the camera's picture may go onto a plane of the display's own
  Mixing mixing = Mixing::automatic;
  bool overlay = false;  // grid, horizon, the building's axes and landmarks over the picture
  std::string cec;       // the adapter by which a television is switched, "/dev/cec0"; empty: none is
  StillContent still;
  MessageStyle messages;
  ClockRules clock;
  OpeningHours opening;
  Duration wake_before{};  // opening, the screen is on again
  std::vector<Era> eras;   // by the wall clock of `opening`; empty: always the same is shown
  CheckSchedule check;
  LadderTimes ladder;
  SnapshotPermission snapshot;
  HeatLimits heat;
  std::optional<VisitorOptions> visitor;  // empty: visitors choose nothing
  std::optional<std::filesystem::path> state_folder;
  std::optional<std::filesystem::path> visitor_content;  // content.toml; content.hpp reads it
};

// [display], [still] and [words] alone: what a screen needs to show anything.
void read_screen(const ConfigTable& root, RunConfig& config);

// Problems are collected in the root's file.
RunConfig read_run_config(const ConfigTable& root);

}  // namespace kasumi
