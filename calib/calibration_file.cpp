#include "calib/calibration_file.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/table/toml_text.hpp"

namespace kasumi {
namespace {

std::string text_of(const Measured& measured, const std::string& camera) {
  auto text = fmt::format("\n[{}.measured.{}]\nutc = {}\nfrom = {}\n", camera, measured.what, measured.utc,
                          toml_string(measured.from));
  for (const auto& [key, value] : measured.numbers)
    if (std::isfinite(value)) text += fmt::format("{} = {}\n", key, toml_number(value));
  if (!measured.picture.empty()) text += fmt::format("picture = {}\n", toml_string(measured.picture));
  std::vector<std::string> remarks;
  for (const auto& remark : measured.remarks) remarks.push_back("  " + toml_string(remark));
  if (!remarks.empty()) text += fmt::format("remarks = [\n{},\n]\n", fmt::join(remarks, ",\n"));
  return text;
}

std::string list(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(fmt::format("{:.9g}", value));
  for (auto& text : texts)
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string text_of(const MeasuredCurve& curve) {
  if (curve.linear()) return "response = \"linear\"\n";
  std::string text = "response = \"table\"\n";
  const auto& tables = curve.light;
  if (tables[0] == tables[1] && tables[1] == tables[2])
    return text + fmt::format("response_table = {}\n", list(tables[0]));
  constexpr std::array kNames{"red", "green", "blue"};
  for (std::size_t c = 0; c < 3; ++c) text += fmt::format("response_table_{} = {}\n", kNames[c], list(tables[c]));
  return text;
}

std::string text_of(const Vignetting& vignetting) {
  return fmt::format("centre_px = [{}, {}]\nradius_px = {}\ncoefficients = [{}, {}, {}]\n",
                     toml_number(vignetting.centre.x), toml_number(vignetting.centre.y),
                     toml_number(vignetting.radius_px), toml_number(vignetting.coefficients[0]),
                     toml_number(vignetting.coefficients[1]), toml_number(vignetting.coefficients[2]));
}

// Keys of [CAMERA] itself.
std::string head_of(const CalibrationStep& step, bool has_response) {
  auto text = fmt::format("width = {}\nheight = {}\n", step.width, step.height);
  if (!step.serial.empty()) text += fmt::format("serial = {}\n", toml_string(step.serial));
  if (step.to_world) {
    const auto angles = heading_pitch_roll(*step.to_world);
    text += fmt::format("heading_deg = {}\npitch_deg = {}\nroll_deg = {}\n", toml_number(to_degrees(angles.heading)),
                        toml_number(to_degrees(angles.pitch)), toml_number(to_degrees(angles.roll)));
  }
  if (step.curve)
    text += text_of(*step.curve);
  else if (step.response && !has_response)
    text += fmt::format("response = {}\n", toml_string(*step.response));
  if (step.sensitivity)
    text += fmt::format("colour_space = \"sensor\"\nsensitivity = {}\n", toml_string(*step.sensitivity));
  if (step.white_balance)
    text += fmt::format("white_balance = {}\n",
                        list({step.white_balance->r, step.white_balance->g, step.white_balance->b}));
  if (step.focus) {
    text += fmt::format("point_spread_px = {}\nsharpening = {}\n", toml_number(step.focus->point_spread_px),
                        toml_number(step.focus->sharpening));
    if (step.focus->jpeg) text += "shared_chroma = true\njpeg_blocks = true\n";
  }
  if (step.mask) text += fmt::format("mask = {}\n", toml_string(*step.mask));
  if (!step.calibrated_utc.empty()) text += fmt::format("calibrated_utc = {}\n", step.calibrated_utc);
  return text;
}

// Puts lines under a table's own header, or makes the header.
void add_under(std::string& text, const std::string& table, const std::string& lines) {
  const std::string header = "[" + table + "]\n";
  if (text.starts_with(header))
    text.insert(header.size(), lines);
  else if (const auto at = text.find("\n" + header); at != std::string::npos)
    text.insert(at + 1 + header.size(), lines);
  else
    text += "\n" + header + lines;
}

struct Old {
  std::string text;  // without what the step replaces
  bool has_response = false;
  bool has_site = false;
};

Result<Old> read_old(const std::filesystem::path& path, const CalibrationStep& step) {
  const auto root = ConfigTable::read_file(path);
  if (!root) return fail(root.error());
  if (!root->has("calibration") || root->integer("calibration") != kCalibrationFormat)
    return fail(FaultKind::bad_input,
                "{}: calibration: expected {}: a file that kasumi calibrate wrote, or a name where there is none",
                path.string(), kCalibrationFormat);
  Old old;
  old.has_site = root->has("site");
  std::map<std::string, std::optional<std::string>> changes;
  const auto drop = [&](const std::string& key) { changes[step.camera + "." + key] = std::nullopt; };
  if (const auto table = root->optional_table(step.camera)) {
    old.has_response = table->has("response");
    const int width = table->integer("width", {}, 0), height = table->integer("height", {}, 0);
    if (width > 0 && height > 0 && (width != step.width || height != step.height))
      return fail(FaultKind::bad_input,
                  "{}: {}: calibrated on {} x {} pictures, and these are {} x {}: expected pictures of one size",
                  path.string(), step.camera, width, height, step.width, step.height);
    for (const char* key : {"width", "height"}) drop(key);
    if (!step.serial.empty()) drop("serial");
    if (!step.calibrated_utc.empty()) drop("calibrated_utc");
    if (step.lens) drop("lens");
    if (step.curve)
      for (const char* key :
           {"response", "response_table", "response_table_red", "response_table_green", "response_table_blue"})
        drop(key);
    if (step.vignetting) drop("vignetting");
    if (step.sensitivity)
      for (const char* key : {"colour_space", "sensitivity"}) drop(key);
    if (step.white_balance) drop("white_balance");
    if (step.mask) drop("mask");
    if (step.noise) drop("noise");
    if (step.focus)
      for (const char* key : {"point_spread_px", "sharpening", "shared_chroma", "jpeg_blocks"}) drop(key);
    if (step.to_world)
      for (const char* key : {"azimuth_up_deg", "heading_deg", "pitch_deg", "roll_deg"}) drop(key);
    for (const auto& measured : step.measured) drop("measured." + measured.what);
  }
  old.text = root->copy_of({"site", "sky", "scene"}, changes);
  return old;
}

// Next to the file; an earlier backup is never overwritten.
std::filesystem::path backup_name(const std::filesystem::path& path) {
  for (int i = 1;; ++i) {
    auto name = path;
    name += fmt::format(".{}.old", i);
    std::error_code error;
    if (!std::filesystem::exists(name, error)) return name;
  }
}

}  // namespace

Result<CalibrationWritten> write_calibration(const std::filesystem::path& path, const CalibrationStep& step) {
  CalibrationWritten written;
  Old old;
  std::error_code error;
  if (std::filesystem::exists(path, error)) {
    auto read = read_old(path, step);
    if (!read) return fail(read.error());
    old = std::move(*read);
    const auto bytes = read_file(path);
    if (!bytes) return fail(bytes.error());
    written.backup = backup_name(path);
    if (auto kept = write_file(*written.backup, *bytes); !kept) return fail(kept.error());
  }
  std::string text = old.text;
  if (step.site && !old.has_site)
    text += fmt::format("\n[site]\nlatitude_deg = {}\nlongitude_deg = {}\naltitude_m = {}\n",
                        toml_number(step.site->latitude_deg), toml_number(step.site->longitude_deg),
                        toml_number(step.site->altitude_m));
  add_under(text, step.camera, head_of(step, old.has_response));
  if (step.lens) text += fmt::format("\n[{}.lens]\n{}", step.camera, toml_of(*step.lens));
  if (step.vignetting) text += fmt::format("\n[{}.vignetting]\n{}", step.camera, text_of(*step.vignetting));
  if (step.noise)
    text += fmt::format("\n[{}.noise]\nfull_scale_electrons = {}\nread_electrons = {}\n", step.camera,
                        toml_number(step.noise->full_scale_electrons), toml_number(step.noise->read_electrons));
  for (const auto& measured : step.measured) text += text_of(measured, step.camera);
  text.insert(0, fmt::format("# Written by kasumi calibrate; docs/cameras.md describes the keys.\n"
                             "calibration = {}\n\n",
                             kCalibrationFormat));
  // A readable file is never replaced by one that cannot be parsed.
  if (const auto again = ConfigTable::parse(text, path); !again) return fail(again.error());
  if (auto done = write_text_file(path, text); !done) return fail(done.error());
  return written;
}

std::filesystem::path drawing_name(const std::filesystem::path& calibration, std::string_view camera,
                                   std::string_view what) {
  auto name = calibration;
  name.replace_extension();
  name += fmt::format(".{}-{}.png", camera, what);
  return name;
}

HeadingPitchRoll heading_pitch_roll(const glm::dmat3& to_world) {
  const glm::dvec3 axis = to_world[2];
  const double level = std::hypot(axis.x, axis.y);
  // Straight up there is no heading; the picture's top then lies at heading + 180 deg, so that roll may be 0.
  const glm::dvec3 top = -to_world[1];
  const Radians heading =
      level > 1e-9 ? Radians{std::atan2(axis.x, axis.y)} : Radians{std::atan2(-top.x * axis.z, -top.y * axis.z)};
  const Radians pitch{std::atan2(axis.z, level)};
  const auto unrolled = camera_to_world(heading, pitch, {0.0});
  const double cosine = glm::dot(to_world[0], unrolled[0]), sine = glm::dot(to_world[0], unrolled[1]);
  return {heading, pitch, {std::atan2(sine, cosine)}};
}

}  // namespace kasumi
