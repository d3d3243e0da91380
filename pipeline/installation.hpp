// One kiosk: its site, its two cameras and the building it shows.
#pragma once

#include "base/config_table.hpp"
#include "calib/camera.hpp"
#include "pipeline/placement.hpp"

namespace kasumi {

struct Installation {
  Site site;
  Camera sky;
  Camera scene;
  ObjectPlacement object;
};

// [site], [sky], [scene], [object] of a fixture or configuration. Problems are left in the root's file.
Installation read_installation(const ConfigTable& root);

}  // namespace kasumi
