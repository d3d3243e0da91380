// The only place that knows the kinds of cameras and displays. Tests substitute their own.
#pragma once

#include <memory>

#include "capture/reconnecting_source.hpp"
#include "gles/display/display.hpp"
#include "pipeline/machine/buttons/input_link.hpp"
#include "pipeline/machine/television.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

enum class CameraRole { sky, scene };

// How to open a camera, and what is known about it beforehand.
struct CameraOpening {
  SourceOpener opener;
  Duration frame_interval{};  // 0: unknown
  bool recorded = false;      // its UTC is the recording's, not the machine's
};

// Its deadlines are made for video; a slow camera gets the same patience in frames.
std::unique_ptr<ReconnectingSource> reconnecting(CameraOpening opening, Clock& clock);

class Devices {
 public:
  virtual ~Devices() = default;
  // Opens nothing yet. The opener's `open` BLOCKS for as long as the camera's driver takes.
  virtual CameraOpening camera(CameraRole role, const CameraOptions& options) = 0;
  virtual Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) = 0;
  // Hotplug events of displays. Null: not available, poll instead.
  virtual std::unique_ptr<DisplayWatch> watch_displays() = 0;
  // Errors: those of open_cec_device().
  virtual Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path& adapter) = 0;
  // Errors: those of open_input_device().
  virtual Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path& device) = 0;
  // Turns it in a thread of its own until it ends.
  virtual void serve(std::shared_ptr<InputLink> link) = 0;
};

// The devices of this machine. Thread-safe; `clock` must outlive it.
std::unique_ptr<Devices> machine_devices(Clock& clock);

}  // namespace kasumi
