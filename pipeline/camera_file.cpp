#include "pipeline/camera_file.hpp"

#include "calib/adopt_calibration.hpp"
#include "pipeline/foreign_keys.hpp"

namespace kasumi {

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  CameraFile found;
  if (root->if_text("calibration")) adopt_calibration(*root);
  if (auto site = root->optional_table("site")) found.site = read_site(*site);
  found.scene = read_camera(root->table("scene"), "scene");
  if (auto sky = root->optional_table("sky")) found.sky = read_camera(*sky, "sky");
  ignore_what_others_read(*root, {"site", "sky", "scene"});
  if (auto done = root->finish(); !done) return fail(done.error());
  return found;
}

}  // namespace kasumi
