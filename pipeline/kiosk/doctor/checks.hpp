// The individual checks of `kasumi doctor`. Each adds its findings.
#pragma once

#include <optional>

#include "pipeline/kiosk/doctor/doctor.hpp"
#include "pipeline/machine/kernel_files.hpp"
#include "pipeline/machine/running_appliance.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

// check_machine.cpp
void check_clock(const ClockRules& options, const ClockState& state, Utc now, Findings& findings);
void check_temperature(const MachinePlaces& places, Findings& findings);
void check_throttling(const MachinePlaces& places, Findings& findings);
void check_disk(const std::filesystem::path& folder, Findings& findings);
void check_watchdogs(const MachinePlaces& places, Findings& findings);

// check_proof.cpp: what `kasumi prove --state` left in the state's folder; nothing where there is none.
void check_proof(const std::filesystem::path& state, Utc now, Findings& findings);

// check_cameras.cpp
const CameraRequest* request_of(const CameraOptions& options);  // null for a recording
struct OpeningTrial {                                           // of `lasted_s` seconds
  bool opened = false;
  std::string problem;  // why it could not be opened, or why no frame came
  std::optional<double> first_frame_s;
  std::optional<CameraMode> mode;
  std::uint64_t good = 0;
  std::map<std::string, std::uint64_t> bad;
  std::uint64_t gaps = 0;
  double lasted_s = 0.0;
};
OpeningTrial measure_camera(const SourceOpener& opener, const Camera& configured, Clock& clock, Duration length);
void check_camera_path(const MachinePlaces& places, const std::string& name, const CameraOptions& options,
                       Findings& findings);
void check_camera_usb(const MachinePlaces& places, const std::string& name, const CameraOptions& options,
                      Findings& findings);
void check_camera(const std::string& name, const CameraOptions& options, const OpeningTrial& camera,
                  Findings& findings);

// check_display.cpp
void check_connectors(const std::vector<ListedCard>& cards, const KmsDisplayOptions& options, Findings& findings);
// Shows plain pictures as fast as the display accepts them.
void check_flips(Display& display, Clock& clock, Findings& findings);
void check_gl_context(const GlInfo& info, Findings& findings);
void check_mixing(const GlInfo& info, Mixing mixing, Findings& findings);

// check_visitor.cpp: which of the visitors' devices are there.
void check_visitor(const VisitorOptions& options, Devices& devices, Findings& findings);

// check_appliance.cpp: judges the running appliance's own status, `later` read some seconds after `before`.
void check_appliance(const RunConfig& config, const RunningAppliance& before, const RunningAppliance& later,
                     double seconds, Findings& findings);

}  // namespace kasumi
