// The one place that knows which cameras and displays there are. Tests stand behind it.
#pragma once

#include <memory>

#include "capture/reconnecting_source.hpp"
#include "gles/display/display.hpp"
#include "pipeline/config/run_config.hpp"

namespace kasumi {

enum class CameraRole { sky, scene };

// How a camera is opened, and what is known of it before.
struct CameraOpening {
  SourceOpener opener;
  Duration frame_interval{};  // between two frames; 0: not known
  bool recorded = false;      // its UTC is the recording's, not the machine's
};

class Devices {
 public:
  virtual ~Devices() = default;
  // Opens nothing yet. The opener's `open` BLOCKS as the camera's driver does.
  virtual CameraOpening camera(CameraRole role, const CameraOptions& options) = 0;
  virtual Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) = 0;
  // Hears of displays that come and go. Null: nobody tells, they are looked for now and then.
  virtual std::unique_ptr<DisplayWatch> watch_displays() = 0;
};

// The machine's. Used by several threads; `clock` must outlive it.
std::unique_ptr<Devices> machine_devices(Clock& clock);

}  // namespace kasumi
