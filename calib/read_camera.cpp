#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/files.hpp"
#include "base/picture_files/upright_picture.hpp"
#include "base/picture_header.hpp"
#include "calib/camera.hpp"
#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {

constexpr Range kTurn_deg{-360.0, 360.0};

glm::dmat3 read_orientation(const ConfigTable& table) {
  const bool looks_up = table.has("azimuth_up_deg");
  const bool has_heading = table.has("heading_deg"), has_pitch = table.has("pitch_deg");
  const bool has_parts = has_heading || has_pitch || table.has("roll_deg");
  const char* either = "either azimuth_up_deg (a camera that looks straight up) or heading_deg, pitch_deg and roll_deg";
  if (!looks_up && !has_parts) {
    table.problem("azimuth_up_deg", either);
    return glm::dmat3{1.0};
  }
  const double azimuth_up = looks_up ? table.number("azimuth_up_deg", kTurn_deg) : 0.0;
  if (looks_up && !has_parts)
    return camera_to_world(from_degrees(azimuth_up - 180.0), from_degrees(90.0), from_degrees(0.0));

  if (looks_up) table.problem("azimuth_up_deg", fmt::format("{}, not both", either));
  const auto unless_looking_up = looks_up ? std::optional(0.0) : std::nullopt;
  const double heading = table.number("heading_deg", kTurn_deg, unless_looking_up);
  const double pitch = table.number("pitch_deg", {-90.0, 90.0}, unless_looking_up);
  const double roll = table.number("roll_deg", kTurn_deg, 0.0);
  return camera_to_world(from_degrees(heading), from_degrees(pitch), from_degrees(roll));
}

std::vector<double> read_curve(const ConfigTable& table, const char* key) {
  const std::vector<double> straight{0.0, 1.0};
  const auto curve = table.numbers(key, 0);
  if (curve.empty()) return straight;  // already reported
  const bool rises = std::adjacent_find(curve.begin(), curve.end(), std::greater_equal<>()) == curve.end();
  if (curve.size() >= 2 && rises && curve.front() == 0.0 && curve.back() == 1.0) return curve;
  table.problem(key,
                "linear light at evenly spaced encoded values, every number larger than the one before, from 0 to 1");
  return straight;
}

Response read_response(const ConfigTable& table) {
  const auto kind = table.choice("response", {"srgb", "linear", "table"});
  if (table.if_text("response") != kind)  // whether there is a table depends on it: the one problem
    for (const char* key : {"response_table", "response_table_red", "response_table_green", "response_table_blue"})
      table.ignore(key);
  if (kind == "linear") return Response::linear();
  if (kind == "srgb") return Response::srgb();
  if (table.has("response_table")) {
    const auto curve = read_curve(table, "response_table");
    return Response::table({curve, curve, curve});
  }
  return Response::table({read_curve(table, "response_table_red"), read_curve(table, "response_table_green"),
                          read_curve(table, "response_table_blue")});
}

// The largest distance from `from` among the pixels that see something.
double farthest_seen_px(const Camera& camera, const glm::dvec2& from) {
  constexpr int kSteps = 64;
  double farthest = 0.0;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const glm::dvec2 pixel{(camera.width - 1.0) * i / kSteps, (camera.height - 1.0) * j / kSteps};
      if (camera.lens->unproject(pixel)) farthest = std::max(farthest, glm::distance(pixel, from));
    }
  return farthest;
}

Vignetting read_vignetting(const ConfigTable& table, const Camera& camera) {
  Vignetting vignetting;
  vignetting.centre = camera.lens->project({0.0, 0.0, 1.0}).value_or(glm::dvec2{});
  const auto given = table.optional_table("vignetting");
  if (!given) return vignetting;

  const auto centre =
      given->numbers("centre_px", 2, {-1e5, 1e5}, std::vector{vignetting.centre.x, vignetting.centre.y});
  vignetting.centre = {centre[0], centre[1]};
  vignetting.radius_px = std::max(1.0, given->number("radius_px", {1.0, 1e5}));
  const auto coefficients = given->numbers("coefficients", 3, {-1e3, 1e3});
  std::copy_n(coefficients.begin(), 3, vignetting.coefficients.begin());

  const auto& v = vignetting.coefficients;
  const double farthest = farthest_seen_px(camera, vignetting.centre) / vignetting.radius_px;
  const auto dark = first_positive_root({1.0, v[0], v[1], v[2]});  // in squares of the radius
  if (dark && std::sqrt(*dark) <= farthest)
    given->problem("coefficients",
                   fmt::format("1 + v2 r^2 + v4 r^4 + v6 r^6 > 0 all over the picture (it is 0 at {:.0f} px from the "
                               "centre, and the picture reaches to {:.0f} px)",
                               std::sqrt(*dark) * vignetting.radius_px, farthest * vignetting.radius_px));
  return vignetting;
}

YuvEncoding read_yuv_encoding(const ConfigTable& table) {
  const auto word = table.choice("yuv_encoding", {"bt601_full", "bt601_limited", "bt709_full", "bt709_limited"},
                                 std::string("bt601_full"));
  for (const auto encoding : {YuvEncoding::bt601_limited, YuvEncoding::bt709_full, YuvEncoding::bt709_limited})
    if (word == name_of(encoding)) return encoding;
  return YuvEncoding::bt601_full;
}

SpectralSensitivity read_sensitivity(const ConfigTable& table, Camera::ColourSpace colour_space) {
  const auto path = table.optional_file("sensitivity");
  std::error_code error;
  if (!path || !std::filesystem::is_regular_file(*path, error)) return generic_sensitivity();
  auto sensitivity = read_spectral_sensitivity(*path);
  if (!sensitivity) {
    table.problem("sensitivity",
                  fmt::format("a spectral sensitivity that can be read:\n{}", sensitivity.error().message));
    return generic_sensitivity();
  }
  if (colour_space == Camera::ColourSpace::sensor && !separates_daylight(*sensitivity)) {
    table.problem("sensitivity", "three channels that differ, to distinguish the colours of the sky");
    return generic_sensitivity();
  }
  return *sensitivity;
}

Image<std::uint8_t> read_mask(const ConfigTable& table, int width, int height) {
  const auto path = table.optional_file("mask");
  std::error_code error;
  if (!path || !std::filesystem::is_regular_file(*path, error)) return {};
  const auto bytes = read_file(*path);
  if (!bytes) {
    table.problem("mask", fmt::format("a file that can be read ({})", bytes.error().message));
    return {};
  }
  const auto header = picture_header(*bytes);
  const auto of_another_size = [&](std::int64_t is_width, std::int64_t is_height) {
    table.problem("mask", fmt::format("a PNG as large as the camera's pictures, {} x {} (it is {} x {})", width, height,
                                      is_width, is_height));
    return Image<std::uint8_t>();
  };
  // Before it is decoded; it may have to be turned.
  if (header && !header->is(width, height) && !header->is(height, width))
    return of_another_size(header->width, header->height);
  const Result<UprightPicture> seen = header ? decode_upright_picture(*header, *bytes) : Result<UprightPicture>();
  if (!seen || seen->picture.empty()) {
    table.problem("mask", seen ? "a PNG" : fmt::format("a PNG that can be read ({})", seen.error().message));
    return {};
  }
  if (seen->picture.cols != width || seen->picture.rows != height)
    return of_another_size(seen->picture.cols, seen->picture.rows);
  const auto grey = mask_of(*seen);
  if (!grey) {
    table.problem("mask", "a PNG " + grey.error().message);
    return {};
  }
  Image<std::uint8_t> mask(width, height);
  for (int y = 0; y < height; ++y) std::copy_n(grey->ptr<std::uint8_t>(y), width, mask.row(y));
  return mask;
}

// A lens calibrated on pictures of another size fits its own keys, but not the camera.
void check_lens(const ConfigTable& lens_table, const Camera& camera) {
  const double width = camera.width, height = camera.height;
  const auto centre = camera.lens->project({0.0, 0.0, 1.0});
  const bool near =
      centre && centre->x >= -width && centre->x <= 2.0 * width && centre->y >= -height && centre->y <= 2.0 * height;
  if (!near) {
    for (const char* key : {"centre_px", "circle_px", "ocamcalib"})
      if (lens_table.has(key))
        lens_table.problem(key, fmt::format("a centre no farther from the {} x {} picture than its own size",
                                            camera.width, camera.height));
  }
  if (const auto path = lens_table.has("ocamcalib") ? lens_table.optional_file("ocamcalib") : std::nullopt) {
    const auto model = read_ocamcalib(*path);
    if (model && (model->width != camera.width || model->height != camera.height))
      lens_table.problem("ocamcalib", fmt::format("a calibration of {} x {} pictures (it is of {} x {})", camera.width,
                                                  camera.height, model->width, model->height));
  }
}

}  // namespace

Site read_site(const ConfigTable& table) {
  Site site;
  site.name = table.text("name", std::string());
  site.latitude_deg = table.number("latitude_deg", {-90.0, 90.0}, std::nullopt);
  site.longitude_deg = table.number("longitude_deg", {-180.0, 180.0}, std::nullopt);
  site.altitude_m = table.number("altitude_m", {-500.0, 9000.0});
  return site;
}

Camera read_camera(const ConfigTable& table, std::string name) {
  constexpr Range kSize_px{16.0, 16384.0};
  Camera camera;
  camera.name = std::move(name);
  camera.width = table.integer("width", kSize_px);
  camera.height = table.integer("height", kSize_px);
  const bool sized = camera.width > 0 && camera.height > 0;

  const auto lens_table = table.table("lens");
  camera.lens = read_lens(lens_table);
  if (sized) check_lens(lens_table, camera);
  camera.to_world = read_orientation(table);
  camera.response = read_response(table);
  camera.vignetting = read_vignetting(table, camera);
  camera.yuv_encoding = read_yuv_encoding(table);
  camera.colour_space = table.choice("colour_space", {"srgb", "sensor"}, std::string("srgb")) == "sensor"
                            ? Camera::ColourSpace::sensor
                            : Camera::ColourSpace::srgb;
  const auto gains = table.numbers("white_balance", 3, {0.01, 100.0}, std::vector{1.0, 1.0, 1.0});
  camera.white_balance = {gains[0], gains[1], gains[2]};
  camera.sensitivity = read_sensitivity(table, camera.colour_space);
  if (sized)
    camera.mask = read_mask(table, camera.width, camera.height);
  else
    table.ignore("mask");
  camera.calibrated_utc = table.optional_utc("calibrated_utc");
  // Notes of kasumi calibrate; informative only.
  table.text("serial", std::string());
  table.ignore("measured");
  return camera;
}

}  // namespace kasumi
