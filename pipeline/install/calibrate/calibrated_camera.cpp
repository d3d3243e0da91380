#include "pipeline/install/calibrate/calibrated_camera.hpp"

#include "calib/calibration_file.hpp"

namespace kasumi {
namespace {

// Keys that are alternatives to each other.
const ConfigTable::Rivals& rivals() {
  static const ConfigTable::Rivals kRivals{
      {"azimuth_up_deg", "heading_deg", "pitch_deg", "roll_deg"},
      {"response", "response_table", "response_table_red", "response_table_green", "response_table_blue"}};
  return kRivals;
}

}  // namespace

Result<Camera> calibrated_camera(const Fixture& fixture, const std::filesystem::path& calibration,
                                 const std::string& camera) {
  const auto& recorded = camera == "sky" ? fixture.installation.sky : fixture.installation.scene;
  std::error_code error;
  if (!std::filesystem::exists(calibration, error)) return recorded;
  const auto root = ConfigTable::read_file(calibration);
  if (!root) return fail(root.error());
  if (!root->has("calibration") || root->integer("calibration") != kCalibrationFormat)
    return fail(FaultKind::bad_input,
                "{}: calibration: expected {}: a file that kasumi calibrate wrote, or a name where there is none",
                calibration.string(), kCalibrationFormat);
  if (!root->has(camera)) return recorded;
  const auto table = root->table(camera);
  const int width = table.integer("width", {}, recorded.width), height = table.integer("height", {}, recorded.height);
  if (width != recorded.width || height != recorded.height)
    return fail(FaultKind::bad_input, "{}: {}: calibrated on {} x {} pictures, the recording's are {} x {}",
                calibration.string(), camera, width, height, recorded.width, recorded.height);
  const auto description = ConfigTable::read_file(fixture.folder / "fixture.toml");
  if (!description) return fail(description.error());
  root->adopt(*description, camera, rivals());
  auto both = read_camera(root->table(camera), camera);
  for (const char* key : {"site", "sky", "scene"}) root->ignore(key);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return both;
}

}  // namespace kasumi
