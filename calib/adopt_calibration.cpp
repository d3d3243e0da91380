#include "calib/adopt_calibration.hpp"

#include "calib/calibration_file.hpp"

namespace kasumi {
namespace {

// Keys that are alternatives to each other.
const ConfigTable::Rivals& rivals() {
  static const ConfigTable::Rivals kRivals{
      {"latitude_deg", "longitude_deg"},
      {"azimuth_up_deg", "heading_deg", "pitch_deg", "roll_deg"},
      {"response", "response_table", "response_table_red", "response_table_green", "response_table_blue"},
      {"depth_map", "depth_step_m", "depth_no_data", "depth_sky_beyond_m", "depth_channel", "depth_inverse_scale",
       "depth_inverse_offset"}};
  return kRivals;
}

Result<ConfigTable> open_calibration(const std::filesystem::path& file) {
  auto root = ConfigTable::read_file(file);
  if (!root) return root;
  if (!root->has("calibration") || root->integer("calibration") != kCalibrationFormat)
    return fail(FaultKind::bad_input, "{}: calibration: expected {}", file.string(), kCalibrationFormat);
  for (const char* table : {"site", "sky", "scene"}) root->ignore(table);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return root;
}

// Empty when the picture sizes agree, as far as both files give them.
std::string size_problem(const ConfigTable& root, const ConfigTable& calibration, const char* camera) {
  const auto here = root.optional_table(camera), there = calibration.optional_table(camera);
  if (!here || !there) return {};
  const auto size = [](const ConfigTable& table, const char* key) { return table.integer(key, {}, 0); };
  const int width = size(*here, "width"), height = size(*here, "height");
  const int other_width = size(*there, "width"), other_height = size(*there, "height");
  const bool same = (width == 0 || other_width == 0 || width == other_width) &&
                    (height == 0 || other_height == 0 || height == other_height);
  if (same) return {};
  return fmt::format("a calibration of {} x {} pictures, the size [{}] gives (that one was done on {} x {})", width,
                     height, camera, other_width, other_height);
}

}  // namespace

std::optional<AdoptedCalibration> adopt_calibration(const ConfigTable& root) {
  if (!root.has("calibration")) {
    root.optional_file("calibration");  // a key that is known
    return std::nullopt;
  }
  const auto file = root.file("calibration");
  const auto refuse = [&](const std::string& expected) {
    if (!expected.empty()) root.problem("calibration", expected);
    root.excuse_missing();
    return std::nullopt;
  };
  std::error_code error;
  if (file.empty() || !std::filesystem::is_regular_file(file, error)) return refuse("");  // already reported
  const auto calibration = open_calibration(file);
  if (!calibration) return refuse(fmt::format("a file that kasumi calibrate wrote:\n{}", calibration.error().message));
  for (const char* camera : {"sky", "scene"})
    if (const auto problem = size_problem(root, *calibration, camera); !problem.empty()) return refuse(problem);

  AdoptedCalibration adopted{file, {}, {}};
  for (const char* table : {"site", "sky", "scene"}) {
    auto [gained, overruled] = root.adopt(*calibration, table, rivals());
    adopted.gained.insert(adopted.gained.end(), gained.begin(), gained.end());
    adopted.overruled.insert(adopted.overruled.end(), overruled.begin(), overruled.end());
  }
  return adopted;
}

}  // namespace kasumi
