// One kiosk: its site, its two cameras and the building it shows.
#pragma once

#include "base/config_table.hpp"
#include "calib/camera.hpp"
#include "pipeline/placement.hpp"

namespace kasumi {

// What lies around the object and above it.
struct Surroundings {
  double ground_albedo = 0.2;    // of sunlight, mean over the visible: grass .2, sand .35, fresh snow .8
  double cloud_base_m = 2000.0;  // above the site: where a cloud that shades the object is looked for in the sky
};

struct Installation {
  Site site;
  Surroundings surroundings;
  Camera sky;
  Camera scene;
  ObjectPlacement object;
};

// [site], [sky], [scene], [object] of a fixture or configuration. Problems are left in the root's file.
Installation read_installation(const ConfigTable& root);

}  // namespace kasumi
