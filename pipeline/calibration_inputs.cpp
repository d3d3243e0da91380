#include "pipeline/calibration_inputs.hpp"

#include "base/files.hpp"
#include "calib/calibration_file.hpp"
#include "capture/replay_source.hpp"

namespace kasumi {
namespace {

// Several ways to say one thing.
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

Result<PicturesRead> look_through(const Fixture& fixture, const Camera& camera, int most,
                                  const std::function<void(const PictureView&, Utc)>& look) {
  UnhurriedClock clock(fixture.info.start_utc);
  auto source = open_replay(fixture.folder / camera.name, clock);
  if (!source) return fail(source.error());
  PicturesRead read;
  const auto rows = static_cast<std::int64_t>((*source)->row_count());
  const std::int64_t wanted = std::min<std::int64_t>(most, rows);
  for (std::int64_t row = 0;; ++row) {
    const auto frame = (*source)->next(Instant::max());
    if (!frame && frame.error().kind == FaultKind::end_of_stream) break;
    // The i-th of the wanted lies in the i-th of as many equal stretches.
    if (row * wanted / rows == (row - 1) * wanted / rows && row > 0) continue;
    if (!frame && frame.error().kind == FaultKind::disconnected) continue;
    if (!frame && frame.error().kind != FaultKind::io) return fail(frame.error());
    const auto decoded = frame ? decode(*frame, camera.yuv_encoding) : Result<DecodedPicture>(fail(frame.error()));
    if (!decoded || decoded->view().width != camera.width || decoded->view().height != camera.height) {
      ++read.damaged;
      continue;
    }
    if (read.good++ == 0) read.first = frame->metadata.utc;
    read.last = frame->metadata.utc;
    look(decoded->view(), frame->metadata.utc);
  }
  if (read.good == 0)
    return fail(FaultKind::bad_input, "{}: {}: no picture of it can be read", fixture.folder.string(), camera.name);
  return read;
}

Result<std::optional<std::filesystem::path>> keep_old(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  for (int i = 1;; ++i) {
    auto name = path;
    name += fmt::format(".{}.old", i);
    if (std::filesystem::exists(name, error)) continue;
    if (auto kept = write_file(name, *bytes); !kept) return fail(kept.error());
    return name;
  }
}

std::filesystem::path beside(const std::filesystem::path& calibration, const std::string& what) {
  auto name = calibration;
  name.replace_extension();
  name += "." + what;
  return name;
}

}  // namespace kasumi
