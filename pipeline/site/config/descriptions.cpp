#include "pipeline/site/config/descriptions.hpp"

#include "calib/adopt_calibration.hpp"
#include "calib/distances/distance_map.hpp"
#include "calib/foreign_keys.hpp"
#include "pipeline/site/config/landmarks.hpp"

namespace kasumi {

Result<CalibrationContents> read_camera_file(const std::filesystem::path& file) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  CalibrationContents found;
  if (root->if_text("calibration")) adopt_calibration(*root);
  if (auto site = root->optional_table("site")) found.site = read_site(*site);
  found.scene = read_camera(root->table("scene"), "scene");
  if (auto sky = root->optional_table("sky")) found.sky = read_camera(*sky, "sky");
  ignore_what_others_read(*root, {"site", "sky", "scene"});
  if (auto done = root->finish(); !done) return fail(done.error());
  return found;
}

Result<LandmarkFile> read_landmark_file(const std::filesystem::path& path, int width, int height) {
  const auto root = ConfigTable::read_file(path);
  if (!root) return fail(root.error());
  if (root->if_text("calibration")) adopt_calibration(*root);
  LandmarkFile found;
  std::optional<Site> site;
  Image<float> distances_m;
  if (auto table = root->optional_table("site")) {
    site = read_site(*table);
    found.altitude_m = site->altitude_m;
  }
  if (auto table = root->optional_table("scene")) {
    found.scene = read_camera(*table, "scene");
    distances_m = read_distance_map(*table, width, height);
    if (found.scene->width != width || found.scene->height != height)
      table->problem("width", fmt::format("{} x {}, as the picture is", width, height));
  }
  found.landmarks =
      read_contrast_landmarks(*root, site, {width, height, found.scene ? &*found.scene : nullptr, &distances_m});
  found.site = site;
  ignore_what_others_read(*root, {"site", "scene", "landmarks"});
  if (found.landmarks.empty())
    root->problem("landmarks", "[[landmarks]] with region_px or ridge_px, and distance_m or a place and a [site]");
  if (auto done = root->finish(); !done) return fail(done.error());
  return found;
}

}  // namespace kasumi
