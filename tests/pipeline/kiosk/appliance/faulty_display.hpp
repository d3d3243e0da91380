// A headless display with faults that a test switches on and off.
#pragma once

#include <memory>
#include <optional>

#include "gles/display/headless_display.hpp"

namespace kasumi {

struct DisplayFaults {
  bool unplugged = false;      // no connector, or no modes
  bool busy = false;           // another program is DRM master
  bool stuck = false;          // flips no longer complete, until told otherwise
  bool opening_mends = false;  // reopening ends `stuck`
  bool context_lost = false;   // once: the GPU was reset
  bool stays_on = false;       // it cannot be turned off
  bool throws = false;         // no memory for drawing
  bool told = false;           // a pending hotplug event
  bool off = false;            // turned off, and no picture shown since
  bool planes = false;         // it has two of its own
  int refused_planes = 0;      // so many of the next pictures on them are refused
  int on_planes = 0;           // pictures that were shown on them
  int composed = 0;            // pictures that were not
  int largest_texture = 0;     // of GL; 0: the driver's
  int opened = 0;
  int tried = 0;                                    // attempts to open it
  std::optional<std::pair<int, int>> other_size{};  // of the mode it comes back with
};

// `faults` must outlive it.
Result<std::unique_ptr<Display>> open_faulty_display(const HeadlessDisplayOptions& options, Clock& clock,
                                                     DisplayFaults& faults);
std::unique_ptr<DisplayWatch> watch_faulty_display(DisplayFaults& faults);
// The picture shown last. Error: nothing has been shown.
Result<Image<Rgb8>> read_picture(Display& display);

}  // namespace kasumi
