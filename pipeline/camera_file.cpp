#include "pipeline/camera_file.hpp"

#include "calib/adopt_calibration.hpp"
#include "pipeline/installation.hpp"

namespace kasumi {

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  CameraFile found;
  if (root->if_text("calibration")) adopt_calibration(*root);
  if (auto site = root->optional_table("site")) {
    found.site = read_site(*site);
    ignore_surroundings(*site);
  }
  found.scene = read_camera(root->table("scene"), "scene");
  if (auto sky = root->optional_table("sky")) found.sky = read_camera(*sky, "sky");
  for (const char* key :
       {"calibration", "format", "name", "description", "licence", "provenance", "start_utc", "object", "landmarks"})
    root->ignore(key);
  for (const char* key : {"point_spread_px", "shared_chroma", "noise", "depth_map", "depth_step_m"})
    if (auto scene = root->optional_table("scene")) scene->ignore(key);
  if (auto done = root->finish(); !done) return fail(done.error());
  return found;
}

}  // namespace kasumi
