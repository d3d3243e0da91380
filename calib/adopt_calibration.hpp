// Adopts the calibration file that a configuration or fixture names; the latter's own keys take precedence.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/table/config_table.hpp"

namespace kasumi {

struct AdoptedCalibration {
  std::filesystem::path file;
  std::vector<std::string> gained;     // full keys: "sky.lens", "scene.heading_deg"
  std::vector<std::string> overruled;  // of them the file naming it says something itself
};

// For a root, before its tables are read. `calibration = "FILE"` is looked for next to it; [site], [sky] and [scene] of
// that file go beneath its own, whole key by whole key (a lens, an orientation, a response is one thing);
// [CAMERA.measured] is left where it is. Empty: the root names none, or one that cannot be used, which is left as one
// problem in the root's file.
std::optional<AdoptedCalibration> adopt_calibration(const ConfigTable& root);

}  // namespace kasumi
