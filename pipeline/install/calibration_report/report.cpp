#include "pipeline/install/calibration_report/report.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/geometry.hpp"
#include "base/table/config_table.hpp"
#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"

namespace kasumi {

namespace {

// Rounded to two digits of the uncertainty.
std::string with_digits(double value, double sigma) {
  const int digits = sigma > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 7) : 3;
  return fmt::format("{:.{}f}", value, digits);
}

std::string with_unit(std::string text, std::string_view unit) {
  return unit.empty() ? text : fmt::format("{} {}", text, unit);
}

struct NamedKey {
  std::string_view key, label;
};
constexpr std::array kLabels{
    NamedKey{"rms_px", "residuals (rms)"},
    NamedKey{"held_out_pinhole_px", "pinhole, on pictures it was not fitted to"},
    NamedKey{"held_out_opencv_fisheye_px", "OpenCV fisheye, on pictures it was not fitted to"},
    NamedKey{"held_out_scaramuzza_px", "Scaramuzza, on pictures it was not fitted to"},
    NamedKey{"farthest_corner_deg", "farthest corner off the axis"},
    NamedKey{"covered", "part of the picture in which the board was seen"},
    NamedKey{"focal_scale", "focal length / initial focal length"},
    NamedKey{"misfit", "residuals / expected residuals"},
    NamedKey{"held_out_steps", "error of unseen pixels, steps of 8 bits"},
    NamedKey{"full_scale_electrons", "electrons at full scale"},
    NamedKey{"read_electrons", "read noise"},
    NamedKey{"edges", "edges used"},
    NamedKey{"point_spread_px", "point spread"},
    NamedKey{"hot_pixels", "hot pixels"},
    NamedKey{"residual", "residuals (rms), of the light"},
    NamedKey{"refraction", "coefficient of refraction"},
    NamedKey{"radius_px", "radius"},
    NamedKey{"field_of_view_deg", "field of view"},
};
constexpr std::array kUnits{NamedKey{"_px", "px"},
                            NamedKey{"_deg", "deg"},
                            NamedKey{"_percent", "%"},
                            NamedKey{"_m", "m"},
                            NamedKey{"_electrons", "electrons"},
                            NamedKey{"_steps", "steps"},
                            NamedKey{"_s", "s"}};

std::string_view unit_of(std::string_view key) {
  for (const auto& [ending, unit] : kUnits)
    if (key.ends_with(ending)) return unit;
  return "";
}

std::string label_of(std::string_view key) {
  for (const auto& [known, label] : kLabels)
    if (key == known) return std::string(label);
  const auto unit = unit_of(key);
  std::string label(unit.empty() ? key : key.substr(0, key.rfind('_')));
  std::ranges::replace(label, '_', ' ');
  return label;
}

void judge(ReportRow& row, std::string_view what, std::string_view key, double value) {
  const auto expectation = expectation_of(what, key);
  if (!expectation) return;
  row.verdict = expectation->verdict(value);
  row.should_be = expectation->text();
  if (row.verdict != Verdict::good) row.remedy = expectation->remedy;
}

// One step's table. Remembers which measured numbers have been shown as the sigma of a value, so that they are not
// listed again.
class Rows {
 public:
  Rows(std::string what, const ConfigTable& measured) : what_(std::move(what)), measured_(measured) {}

  void text(std::string label, std::string value) {
    rows_.push_back({std::move(label), std::move(value), "", "", "", {}});
  }

  // A value with its standard deviation, which the step calls `sigma_key`.
  void value(std::string label, double value, const std::string& sigma_key, std::string_view unit) {
    shown_.insert(sigma_key);
    const auto sigma = measured_.if_number(sigma_key);
    ReportRow row{std::move(label), with_unit(with_digits(value, sigma.value_or(0.0)), unit), "", "", "", {}};
    if (sigma) {
      row.sigma = with_unit(fmt::format("{:.2g}", *sigma), unit);
      judge(row, what_, sigma_key, *sigma);
    }
    rows_.push_back(std::move(row));
  }

  // Some steps give the focal length's sigma in pixels, others in percent.
  void focal(double focal_px) {
    const auto px = measured_.if_number("focal_sigma_px"), percent = measured_.if_number("focal_sigma_percent");
    shown_.insert({"focal_sigma_px", "focal_sigma_percent"});
    const double sigma_px = px ? *px : percent.value_or(0.0) * 0.01 * focal_px;
    ReportRow row{"focal length", with_unit(with_digits(focal_px, sigma_px), "px"), "", "", "", {}};
    if (px || percent) {
      row.sigma = fmt::format("{:.2g} px ({:.2g} %)", sigma_px, 100.0 * sigma_px / focal_px);
      judge(row, what_, "focal_sigma_percent", 100.0 * sigma_px / focal_px);
    }
    rows_.push_back(std::move(row));
  }

  // The standard deviation of a quantity whose value is not shown.
  void sigma(std::string label, const std::string& key) {
    const auto sigma = measured_.if_number(key);
    if (!sigma) return;
    shown_.insert(key);
    ReportRow row{std::move(label), "", with_unit(fmt::format("{:.2g}", *sigma), unit_of(key)), "", "", {}};
    judge(row, what_, key, *sigma);
    rows_.push_back(std::move(row));
  }

  std::vector<ReportRow> with_the_rest() && {
    for (const auto& key : measured_.keys()) {
      if (shown_.contains(key) || key == "from" || key == "picture") continue;
      if (const auto number = measured_.if_number(key)) {
        ReportRow row{label_of(key), with_unit(fmt::format("{:.4g}", *number), unit_of(key)), "", "", "", {}};
        judge(row, what_, key, *number);
        rows_.push_back(std::move(row));
      } else if (const auto value = measured_.if_text(key)) {
        text(label_of(key), *value);
      }
    }
    return std::move(rows_);
  }

 private:
  std::string what_;
  const ConfigTable& measured_;
  std::vector<ReportRow> rows_;
  std::set<std::string> shown_;
};

void add_lens(Rows& rows, const ConfigTable& camera, bool centre) {
  const auto table = camera.optional_table("lens");
  if (!table) return;
  const auto lens = read_lens_description(*table);
  rows.text("model", std::string(model_name(lens)));
  rows.focal(focal_px_of(lens));
  if (centre) {
    rows.value("centre, x", centre_of(lens).x, "centre_x_sigma_px", "px");
    rows.value("centre, y", centre_of(lens).y, "centre_y_sigma_px", "px");
  }
  if (!std::holds_alternative<PinholeParameters>(lens.model))
    rows.text("used up to, off the axis", fmt::format("{:.1f} deg", to_degrees(lens.largest_angle)));
}

void add_orientation(Rows& rows, const ConfigTable& camera) {
  const double pitch_deg = camera.number("pitch_deg", {-90, 90}, 90.0);
  const auto to_world = camera_to_world(from_degrees(camera.number("heading_deg", {}, 0.0)), from_degrees(pitch_deg),
                                        from_degrees(camera.number("roll_deg", {}, 0.0)));
  const double top_deg = to_degrees(azimuth_angle(-to_world[1]));
  rows.value("azimuth of the picture's top", top_deg, "azimuth_sigma_deg", "deg");
  rows.value("tilt to the east", to_degrees({std::asin(to_world[2].x)}), "tilt_east_sigma_deg", "deg");
  rows.value("tilt to the north", to_degrees({std::asin(to_world[2].y)}), "tilt_north_sigma_deg", "deg");
}

void add_pose(Rows& rows, const ConfigTable& camera) {
  rows.value("heading", camera.number("heading_deg", {}, 0.0), "heading_sigma_deg", "deg");
  rows.value("pitch", camera.number("pitch_deg", {}, 0.0), "pitch_sigma_deg", "deg");
  rows.value("roll", camera.number("roll_deg", {}, 0.0), "roll_sigma_deg", "deg");
  rows.sigma("direction of any pixel", "anywhere_sigma_deg");
}

void add_vignetting(Rows& rows, const ConfigTable& camera) {
  const auto table = camera.optional_table("vignetting");
  if (!table) return;
  const auto v = table->numbers("coefficients", 3);
  rows.value("illumination at the rim, centre = 1", 1.0 + v[0] + v[1] + v[2], "rim_sigma", "");
  rows.text("coefficients",
            fmt::format("{:.4f}, {:.4f}, {:.4f} over {:.1f} px", v[0], v[1], v[2], table->number("radius_px")));
}

std::vector<ReportRow> rows_of(const std::string& what, const ConfigTable& camera, const ConfigTable& measured) {
  Rows rows(what, measured);
  if (what == "lens") add_lens(rows, camera, true);
  if (what == "orientation") {
    add_orientation(rows, camera);
    add_lens(rows, camera, true);
  }
  if (what == "pose") {
    add_pose(rows, camera);
    add_lens(rows, camera, false);
  }
  if (what == "response") rows.text("curve", camera.if_text("response").value_or("unknown"));
  if (what == "vignetting") add_vignetting(rows, camera);
  return std::move(rows).with_the_rest();
}

std::string title_of(const std::string& camera, const std::string& what) {
  for (const auto& step : required_steps())
    if (step.camera == camera && step.what == what) return std::string(step.title);
  std::string title = label_of(what);
  if (!title.empty() && title[0] >= 'a' && title[0] <= 'z') title[0] = static_cast<char>(title[0] - 'a' + 'A');
  return title;
}

ReportStep step_of(const std::filesystem::path& calibration, const std::string& name, const std::string& what,
                   const ConfigTable& camera, const ConfigTable& measured) {
  ReportStep step;
  step.title = title_of(name, what);
  if (const auto utc = measured.optional_utc("utc")) step.utc = utc_text(*utc);
  step.from = measured.text("from", "");
  step.remarks = measured.texts("remarks");
  step.rows = rows_of(what, camera, measured);
  // Only the last part of a name is trusted: a report shows no file from another folder.
  const auto noted = std::filesystem::path(measured.text("picture", "")).filename();
  const auto drawing = noted.empty() ? drawing_name(calibration, name, what) : calibration.parent_path() / noted;
  if (auto bytes = read_file(drawing)) step.picture = std::move(*bytes);
  if (!noted.empty() || !step.picture.empty()) step.picture_name = drawing.filename().string();
  return step;
}

ReportSection camera_of(const std::filesystem::path& calibration, const std::string& name, const ConfigTable& root) {
  ReportSection report{name, "", {}, {}};
  const auto camera = root.optional_table(name);
  const auto measured = camera ? camera->optional_table("measured") : std::nullopt;
  std::vector<std::string> order;
  for (const auto& step : required_steps()) {
    if (step.camera != name) continue;
    // A mask counts as done when it has a file; a lens written by hand is not measured.
    const bool done = (measured && measured->has(step.what)) || (step.what == "mask" && camera && camera->has("mask"));
    if (!done) report.missing.push_back(step);
    if (measured && measured->has(step.what)) order.emplace_back(step.what);
  }
  if (!camera) return report;
  report.description =
      fmt::format("{} x {} pixels", camera->integer("width", {1, 16384}, 0), camera->integer("height", {1, 16384}, 0));
  if (const auto serial = camera->if_text("serial")) report.description += ", serial " + *serial;
  if (const auto utc = camera->optional_utc("calibrated_utc"))
    report.description += ", last calibrated " + utc_text(*utc);
  if (!measured) return report;
  for (const auto& what : measured->keys())
    if (std::ranges::find(order, what) == order.end()) order.push_back(what);
  for (const auto& what : order)
    if (const auto table = measured->optional_table(what))
      report.steps.push_back(step_of(calibration, name, what, *camera, *table));
  return report;
}

}  // namespace

Result<CalibrationReport> read_calibration_report(const std::filesystem::path& calibration) {
  auto text = read_text_file(calibration);
  if (!text) return fail(text.error());
  const auto root = ConfigTable::parse(*text, calibration);
  if (!root) return fail(root.error());
  if (!root->has("calibration") || root->if_number("calibration") != kCalibrationFormat)
    return fail(FaultKind::bad_input, "{}: calibration: expected {}: a file that kasumi calibrate wrote",
                calibration.string(), kCalibrationFormat);
  CalibrationReport report;
  report.name = calibration.filename().string();
  report.file = std::move(*text);
  if (const auto site = root->optional_table("site")) {
    const auto place = read_site(*site);
    report.site = fmt::format("{}{:.5f} deg north, {:.5f} deg east, {:.0f} m above the sea",
                              place.name.empty() ? "" : place.name + ": ", place.latitude_deg, place.longitude_deg,
                              place.altitude_m);
  }
  for (const char* name : {"sky", "scene"}) report.cameras.push_back(camera_of(calibration, name, *root));
  for (const auto& key : root->keys()) root->ignore(key);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return report;
}

}  // namespace kasumi
