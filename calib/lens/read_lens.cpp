#include <algorithm>
#include <cmath>

#include "calib/lens/lens_description.hpp"

namespace kasumi {
namespace {

constexpr Range kFocal_px{1.0, 1e6};
constexpr Range kPosition_px{-1e5, 1e5};
constexpr Range kLargestAngle_deg{1.0, 180.0};

Radians read_largest_angle(const ConfigTable& table, double fallback_deg = 90.0) {
  return from_degrees(table.number("largest_angle_deg", kLargestAngle_deg, fallback_deg));
}

glm::dvec2 read_centre(const ConfigTable& table) {
  const auto centre = table.numbers("centre_px", 2, kPosition_px);
  return {centre[0], centre[1]};
}

glm::dvec2 read_focal_pair(const ConfigTable& table) {
  const auto focal = table.numbers("focal_px", 2, kFocal_px);
  return {std::max(focal[0], kFocal_px.lowest), std::max(focal[1], kFocal_px.lowest)};
}

// Either focal length and centre, or the field of view and the circle it fills: the circle's edge is fov / 2 off the
// axis.
LensDescription read_ideal_fisheye(const ConfigTable& table, bool equisolid) {
  const bool by_circle = table.has("fov_deg") || table.has("circle_px");
  if (!by_circle) {
    const double focal_px = table.number("focal_px", kFocal_px);
    return {IdealFisheyeParameters{read_centre(table), focal_px, equisolid}, read_largest_angle(table)};
  }
  const char* either = "either focal_px and centre_px or fov_deg and circle_px, not both";
  if (table.has("focal_px") && table.number("focal_px") != 0.0) table.problem("focal_px", either);
  if (table.has("centre_px") && !table.numbers("centre_px", 0).empty()) table.problem("centre_px", either);
  const double fov_deg = table.number("fov_deg", {2.0, 360.0});
  auto circle = table.numbers("circle_px", 3, kPosition_px);
  if (table.has("circle_px") && !(circle[2] >= 1.0)) table.problem("circle_px", "[x, y, radius] with a radius >= 1");
  circle[2] = std::max(circle[2], 1.0);
  const double edge = from_degrees(0.5 * fov_deg).value;
  const double focal_px = circle[2] / (equisolid ? 2.0 * std::sin(0.5 * edge) : edge);
  return {IdealFisheyeParameters{{circle[0], circle[1]}, focal_px, equisolid},
          read_largest_angle(table, 0.5 * fov_deg)};
}

LensDescription read_opencv_fisheye(const ConfigTable& table) {
  const auto focal = read_focal_pair(table);
  const auto centre = read_centre(table);
  const auto k = table.numbers("k", 4, {-1e3, 1e3});
  return {OpencvFisheyeParameters{focal, centre, {k[0], k[1], k[2], k[3]}}, read_largest_angle(table)};
}

ScaramuzzaParameters read_scaramuzza_model(const ConfigTable& table) {
  const ScaramuzzaParameters some_valid_one{{-500.0, 0.0, 1e-3}, {}, 1.0, 0.0, 0.0, 0, 0};
  if (const auto path = table.optional_file("ocamcalib")) {
    for (const char* key : {"polynomial", "centre_px", "affine"})
      if (table.has(key) && !table.numbers(key, 0).empty())
        table.problem(key, "either ocamcalib or polynomial, centre_px and affine, not both");
    std::error_code error;
    if (!std::filesystem::is_regular_file(*path, error)) return some_valid_one;  // already reported by optional_file
    auto model = read_ocamcalib(*path);
    if (!model)
      table.problem("ocamcalib", fmt::format("a calibration exported by OCamCalib ({})", model.error().message));
    return model.value_or(some_valid_one);
  }
  ScaramuzzaParameters model = some_valid_one;
  const auto polynomial = table.numbers("polynomial", 0);
  if (polynomial.size() >= 2 && polynomial.size() <= 20 && polynomial[0] < 0.0)
    model.polynomial = polynomial;
  else if (!polynomial.empty())
    table.problem("polynomial",
                  "2 to 20 coefficients a0, a1, ... with a0 < 0 (a model with the opposite sign: turn every sign)");
  table.numbers("focal_px", 2, kFocal_px, std::vector{1.0, 1.0});  // for people: the polynomial has it
  model.centre = read_centre(table);
  const auto affine = table.numbers("affine", 3, {-10.0, 10.0}, std::vector{1.0, 0.0, 0.0});
  if (affine[0] - affine[1] * affine[2] > 0.0) {
    model.c = affine[0];
    model.d = affine[1];
    model.e = affine[2];
  } else {
    table.problem("affine", "[c, d, e] with c - d e > 0");
  }
  return model;
}

LensDescription read_pinhole(const ConfigTable& table) {
  PinholeParameters model{read_focal_pair(table), read_centre(table), {}};
  const std::vector<double> none(5, 0.0);
  const auto distortion = table.numbers("distortion", 0, {-1e4, 1e4}, none);
  if (distortion.size() == 4 || distortion.size() == 5)
    std::copy(distortion.begin(), distortion.end(), model.distortion.begin());
  else
    table.problem("distortion", "[k1, k2, p1, p2, k3] as OpenCV orders them (k3 may be left out)");
  return {model};
}

}  // namespace

LensDescription read_lens_description(const ConfigTable& table) {
  const auto model = table.choice("model", {"equidistant", "equisolid", "opencv_fisheye", "scaramuzza", "pinhole"});
  if (table.if_text("model") != model) {  // which other keys there are depends on it: the one problem
    for (const auto& other : table.keys()) table.ignore(other);
    return {};
  }
  if (model == "pinhole") return read_pinhole(table);
  LensDescription fisheye = model == "opencv_fisheye" ? read_opencv_fisheye(table)
                            : model == "scaramuzza"
                                ? LensDescription{read_scaramuzza_model(table), read_largest_angle(table)}
                                : read_ideal_fisheye(table, model == "equisolid");
  fisheye.mirrored = table.flag("mirrored", false);
  return fisheye;
}

LensPtr read_lens(const ConfigTable& table) {
  return make_lens(read_lens_description(table));
}

}  // namespace kasumi
