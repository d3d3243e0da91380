// A display nobody sees, whose faults a test turns on and off.
#pragma once

#include <memory>
#include <optional>

#include "gles/headless_display.hpp"

namespace kasumi {

struct DisplayFaults {
  bool unplugged = false;      // no connector, or no modes
  bool busy = false;           // somebody else is DRM master
  bool stuck = false;          // flips do not complete any more, until it is opened anew
  bool opening_mends = false;  // it is stuck until it is opened anew
  bool context_lost = false;   // once: the GPU was reset
  int opened = 0;
  std::optional<std::pair<int, int>> other_size{};  // of the mode it comes back with
};

// `faults` must outlive it.
Result<std::unique_ptr<Display>> open_faulty_display(const HeadlessDisplayOptions& options, Clock& clock,
                                                     DisplayFaults& faults);
// The picture shown last. Error: nothing has been shown.
Result<Image<Rgb8>> read_picture(Display& display);

}  // namespace kasumi
