// OpenCV, ROS, Kalibr and ORB-SLAM: keys with numbers, and a model by its name or by what is there.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "calib/lens/choose_camera.hpp"
#include "calib/lens/foreign_formats.hpp"
#include "calib/lens/key_file.hpp"

namespace kasumi {
namespace {

enum class NamedProjection {
  unknown,
  brown,
  rational,
  fisheye,
  omnidirectional,
  double_sphere,
  extended_unified,
  field_of_view,
  none
};

NamedProjection model_named(std::string name) {
  std::erase_if(name, [](unsigned char c) { return !std::isalnum(c); });
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto is = [&](std::initializer_list<const char*> names) {
    return std::ranges::any_of(names, [&](const char* one) { return name == one; });
  };
  if (is({"plumbbob", "radtan", "brown", "brownconrady", "pinhole", "perspective", "radialtangential", "opencv",
          "standard"}))
    return NamedProjection::brown;
  if (is({"rationalpolynomial", "rational", "fullopencv", "thinprism"})) return NamedProjection::rational;
  if (is({"fisheye", "opencvfisheye", "equidistant", "equi", "kannalabrandt", "kannalabrandt4", "kannalabrandt8", "kb4",
          "kb8", "kb"}))
    return NamedProjection::fisheye;
  if (is({"omnidir", "omni", "omnidirectional", "mei", "unified", "catadioptric"}))
    return NamedProjection::omnidirectional;
  if (is({"ds", "doublesphere"})) return NamedProjection::double_sphere;
  if (is({"eucm", "extendedunified"})) return NamedProjection::extended_unified;
  if (is({"fov", "atan"})) return NamedProjection::field_of_view;
  if (is({"none", "nodistortion", "rectified"})) return NamedProjection::none;
  return NamedProjection::unknown;
}

// Keys of results and settings that say nothing of where light falls.
const std::set<std::string, std::less<>> kHarmless{"nframes",
                                                   "ret",
                                                   "error",
                                                   "mean_error",
                                                   "version",
                                                   "nr_of_frames",
                                                   "framesCount",
                                                   "board_width",
                                                   "board_height",
                                                   "boardWidth",
                                                   "boardHeight",
                                                   "board_size",
                                                   "square_size",
                                                   "squareSize",
                                                   "marker_size",
                                                   "flags",
                                                   "flagValue",
                                                   "calibFlags",
                                                   "aspectRatio",
                                                   "aspect_ratio",
                                                   "fix_aspect_ratio",
                                                   "avg_reprojection_error",
                                                   "rms",
                                                   "reprojection_error",
                                                   "per_view_reprojection_errors",
                                                   "extrinsic_parameters",
                                                   "image_points",
                                                   "grid_points",
                                                   "camera_matrix_std_dev",
                                                   "cameraMatrixStdDev",
                                                   "dist_coeffs_std_dev",
                                                   "std_dev",
                                                   "rvecs",
                                                   "tvecs",
                                                   "rotation_vectors",
                                                   "translation_vectors",
                                                   "rectification_matrix",
                                                   "projection_matrix",
                                                   "header",
                                                   "cam_overlaps",
                                                   "timeshift_cam_imu",
                                                   "T_cam_imu",
                                                   "T_imu_cam",
                                                   "T_cn_cnm1",
                                                   "calibration_time",
                                                   "calibrationDate",
                                                   "time",
                                                   "fps",
                                                   "RGB",
                                                   "bf",
                                                   "ThDepth",
                                                   "DepthMapFactor",
                                                   "idx",
                                                   "img_idx",
                                                   "xi_std_dev",
                                                   "date",
                                                   "R",
                                                   "P",
                                                   "r",
                                                   "p"};

using Keys = std::initializer_list<const char*>;
constexpr const char* kNone = "";

struct KeyedCoefficients {
  std::vector<double> values;
  Keys names;
};

std::optional<SensorMatrix> matrix_of(const KeyFile& file, const std::string& at, Problems& problems) {
  const auto k = file.numbers({"camera_matrix", "cameraMatrix", "CameraMatrix", "Camera_Matrix", "K", "k", "mtx"}, at);
  if (k.size() == 9 && k[0] >= 1.0 && k[4] >= 1.0 && k[8] == 1.0 && k[3] == 0.0)
    return SensorMatrix{k[0], k[4], k[2], k[5], k[1]};
  if (k.empty()) {
    const std::string slam = file.has("Camera1.fx") ? "Camera1." : "Camera.";
    const auto fx = file.number({"fx"}, slam), fy = file.number({"fy"}, slam), cx = file.number({"cx"}, slam),
               cy = file.number({"cy"}, slam);
    if (fx && fy && cx && cy && *fx >= 1.0 && *fy >= 1.0) return SensorMatrix{*fx, *fy, *cx, *cy, 0.0};
  }
  problems.add("camera_matrix: expected 9 numbers [fx skew cx; 0 fy cy; 0 0 1] with fx, fy >= 1");
  return std::nullopt;
}

std::vector<double> distortion_of(const KeyFile& file, const std::string& at) {
  auto found = file.numbers({"distortion_coefficients", "distortion_coeffs", "distCoeffs", "DistCoeffs", "dist_coeffs",
                             "dist_coeff", "Distortion_Coefficients", "D", "d", "dist"},
                            at);
  if (!found.empty()) return found;
  const std::string slam = file.has("Camera1.fx") ? "Camera1." : "Camera.";
  if (!file.has(slam + "k1")) return {};
  const auto one = [&](const char* key) { return file.number({key}, slam).value_or(0.0); };
  if (file.has(slam + "p1")) return {one("k1"), one("k2"), one("p1"), one("p2"), one("k3")};
  return {one("k1"), one("k2"), one("k3"), one("k4")};
}

void read_size(const KeyFile& file, const std::string& at, ForeignLens& lens, Problems& problems) {
  const auto width = file.number({"image_width", "imageWidth", "width", "Camera.width"}, at),
             height = file.number({"image_height", "imageHeight", "height", "Camera.height"}, at);
  auto size =
      file.numbers({"image_size", "imageSize", "cameraResolution", "resolution", "image_Size", "DIM", "dim"}, at);
  if (width && height) size = {*width, *height};
  if (size.size() == 2 && size[0] >= 1.0 && size[1] >= 1.0 && size[0] <= 1e5 && size[1] <= 1e5) {
    lens.width = static_cast<int>(size[0]);
    lens.height = static_cast<int>(size[1]);
  } else {
    problems.add("image_width, image_height: expected the size of the calibration's pictures");
  }
}

// ROS's camera_info: its numbers are of whole pictures of the sensor; others would have another size and centre.
void check_whole_pictures(const KeyFile& file, const ForeignLens& lens, Problems& problems) {
  for (const char* key : {"binning_x", "binning_y"})
    if (const auto pixels = file.number({key}); pixels && *pixels > 1.0)
      problems.add("{}: {:.0f} pixels become one in the pictures: expected a calibration of the pictures as they come",
                   key, *pixels);
  const auto part = [&](const char* key, double whole) {
    const auto value = file.number({key});
    if (value && *value != 0.0 && *value != whole)
      problems.add(
          "{}: {}, pictures are a part of the sensor's: expected 0, a calibration of the pictures as they come", key,
          *value);
  };
  part("roi.x_offset", 0.0);
  part("roi.y_offset", 0.0);
  part("roi.width", lens.width);
  part("roi.height", lens.height);
}

BrownCoefficients brown_of(const std::vector<double>& distortion) {
  BrownCoefficients k{};
  std::copy_n(distortion.begin(), std::min(distortion.size(), k.size()), k.begin());
  return k;
}

void set_double_sphere(ForeignLens& lens, const SensorMatrix& matrix, double xi, double alpha) {
  lens.is_fisheye = true;
  lens.project = [=](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double d1 = glm::length(ray), z1 = xi * d1 + ray.z, d2 = std::hypot(ray.x, ray.y, z1),
                 depth = alpha * d2 + (1.0 - alpha) * z1;
    const double w1 = alpha > 0.5 ? (1.0 - alpha) / alpha : alpha / (1.0 - alpha),
                 w2 = (w1 + xi) / std::sqrt(2.0 * w1 * xi + xi * xi + 1.0);
    if (!(depth > 1e-9) || !(ray.z > -w2 * d1)) return std::nullopt;
    return matrix({ray.x / depth, ray.y / depth});
  };
}

void set_extended_unified(ForeignLens& lens, const SensorMatrix& matrix, double alpha, double beta) {
  lens.is_fisheye = true;
  lens.project = [=](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double d = std::sqrt(beta * (ray.x * ray.x + ray.y * ray.y) + ray.z * ray.z),
                 depth = alpha * d + (1.0 - alpha) * ray.z;
    const double w = alpha > 0.5 ? (1.0 - alpha) / alpha : alpha / (1.0 - alpha);
    if (!(depth > 1e-9) || !(ray.z > -w * d)) return std::nullopt;
    return matrix({ray.x / depth, ray.y / depth});
  };
}

// Of a camchain: cam0, cam1, ...
std::vector<ListedLens> kalibr_cameras(const KeyFile& file) {
  std::vector<ListedLens> cameras;
  for (std::string name = "cam0"; file.has(name + ".intrinsics"); name = fmt::format("cam{}", cameras.size())) {
    const auto camera = file.text({"camera_model"}, name + ".").value_or(""),
               bent = file.text({"distortion_model"}, name + ".").value_or("none"),
               topic = file.text({"rostopic"}, name + ".").value_or("");
    ListedLens found{{name, name.substr(3)}, fmt::format("{}-{}", camera, bent)};
    if (!topic.empty()) {
      found.names.push_back(topic);
      found.words += ", " + topic;
    }
    cameras.push_back(std::move(found));
  }
  return cameras;
}

// Kalibr: camera_model, intrinsics, distortion_model, distortion_coeffs of each camera.
Result<ForeignLens> read_kalibr(const KeyFile& file, const std::string& wanted) {
  const auto cameras = kalibr_cameras(file);
  const auto chosen = choose_camera(cameras, wanted);
  if (!chosen) return fail(chosen.error());
  const std::string at = cameras[*chosen].names.front() + ".";
  Problems problems;
  ForeignLens lens{"Kalibr", "", 0, 0, {}, {}, false, {}};
  read_size(file, at, lens, problems);
  const auto camera = file.text({"camera_model"}, at).value_or(""),
             bent = file.text({"distortion_model"}, at).value_or("none");
  const auto n = file.numbers({"intrinsics"}, at);
  auto d = file.numbers({"distortion_coeffs"}, at);
  lens.model = camera + "-" + bent;
  const auto camera_model = model_named(camera), distortion = model_named(bent);
  const std::size_t extra =
      camera_model == NamedProjection::omnidirectional                                                      ? 1
      : camera_model == NamedProjection::double_sphere || camera_model == NamedProjection::extended_unified ? 2
                                                                                                            : 0;
  if (camera_model == NamedProjection::unknown)
    problems.add("camera_model \"{}\": expected pinhole, omni, ds or eucm", camera);
  if (distortion == NamedProjection::unknown)
    problems.add("distortion_model \"{}\": expected radtan, equidistant, fov or none", bent);
  if (n.size() != 4 + extra || n[extra] < 1.0 || n[extra + 1] < 1.0)
    problems.add("intrinsics: {} numbers: expected {} of {}", n.size(), 4 + extra, camera);
  const bool brown = distortion == NamedProjection::brown || distortion == NamedProjection::none;
  if (extra > 0 && !(brown && (extra == 1 || std::ranges::all_of(d, [](double x) { return x == 0.0; }))))
    problems.add("distortion_model \"{}\" of {} with {} distortion_coeffs: expected {}", bent, camera, d.size(),
                 extra == 1 ? "radtan or none" : "none, and no coefficients");
  if (distortion == NamedProjection::field_of_view && (d.size() != 1 || !(d[0] > 0.0 && d[0] < 3.0)))
    problems.add("distortion_coeffs: expected one number of fov, 0 to 3");
  if ((distortion == NamedProjection::fisheye || distortion == NamedProjection::brown) && d.size() != 4)
    problems.add("distortion_coeffs: {} numbers, expected 4", d.size());
  const auto of_another = [&](const std::string& key) {
    return std::ranges::any_of(cameras, [&](const ListedLens& other) {
      const auto its = other.names.front() + ".";
      return its != at && key.starts_with(its);
    });
  };
  for (const auto& key : file.unread(kHarmless))
    if (!of_another(key)) problems.add("{}: not a key whose meaning is known here", key);
  if (!problems.empty()) return fail(problems.fault());
  const SensorMatrix matrix{n[extra], n[extra + 1], n[extra + 2], n[extra + 3], 0.0};
  switch (camera_model) {
    case NamedProjection::omnidirectional: set_omnidirectional(lens, matrix, n[0], brown_of(d)); break;
    case NamedProjection::double_sphere: set_double_sphere(lens, matrix, n[0], n[1]); break;
    case NamedProjection::extended_unified: set_extended_unified(lens, matrix, n[0], n[1]); break;
    default:
      if (distortion == NamedProjection::fisheye)
        set_fisheye(lens, matrix, {d[0], d[1], d[2], d[3]});
      else if (distortion == NamedProjection::field_of_view)
        set_field_of_view(lens, matrix, d[0]);
      else
        set_pinhole(lens, matrix, brown_of(d));
  }
  return lens;
}

std::string program_of(const KeyFile& file) {
  if (file.has("Camera.fx") || file.has("Camera1.fx")) return "ORB-SLAM";
  return file.has("projection_matrix") && file.has("rectification_matrix") ? "ROS" : "OpenCV";
}

// By the file's word for its model, by xi, or by `--model`.
NamedProjection model_of(const KeyFile& file, std::size_t coefficients, bool has_xi, const ImportQuestions& questions,
                         std::string& name, Problems& problems) {
  const auto word = file.text({"distortion_model", "camera_model", "cameraModel", "Camera.type", "camera_type",
                               "model_type", "projection_model", "lens_model", "model"});
  const bool flagged = file.number({"fisheye_model"}).value_or(0.0) != 0.0;
  name = word.value_or(flagged ? "fisheye" : has_xi ? "omnidir" : "");
  if (has_xi) return NamedProjection::omnidirectional;
  if (flagged) return NamedProjection::fisheye;
  if (word) {
    const auto model = model_named(*word);
    if (model == NamedProjection::unknown || model == NamedProjection::double_sphere ||
        model == NamedProjection::extended_unified || model == NamedProjection::field_of_view)
      problems.add(
          "model \"{}\": expected plumb_bob, rational_polynomial, pinhole; fisheye, equidistant, KannalaBrandt8; "
          "or omnidir with xi",
          *word);
    return model;
  }
  if (coefficients != 4 || file.has("fisheye_model")) return NamedProjection::brown;
  if (questions.model == "opencv_fisheye" || questions.model == "pinhole") {
    name = questions.model;
    return questions.model == "pinhole" ? NamedProjection::brown : NamedProjection::fisheye;
  }
  problems.add(
      "four distortion coefficients may be a pinhole's k1, k2, p1, p2 or a fisheye's k1, k2, k3, k4: expected "
      "--model pinhole or --model opencv_fisheye");
  return NamedProjection::unknown;
}

}  // namespace

bool is_kalibr(const std::string& text) {
  const auto file = KeyFile::parse(text);
  return file && file->has("cam0.intrinsics");
}

Result<ForeignLens> read_keyed_lens(const std::string& text, const ImportQuestions& questions) {
  const auto file = KeyFile::parse(text);
  if (!file) return fail(file.error());
  if (file->has("cam0.intrinsics")) return read_kalibr(*file, questions.camera);
  Problems problems;
  ForeignLens lens{program_of(*file), "", 0, 0, {}, {}, false, {}};
  auto matrix = matrix_of(*file, kNone, problems);
  auto distortion = distortion_of(*file, kNone);
  const auto xi = file->number({"xi", "Xi"});
  const auto model = model_of(*file, distortion.size(), xi.has_value(), questions, lens.model, problems);
  if (lens.model.empty()) lens.model = "pinhole";
  // cv::fisheye's and omnidir's scripts keep the skew apart: x = fx (x' + alpha y').
  if (const auto alpha = file->number({"alpha", "skew_coefficient"}); alpha && matrix)
    matrix->skew += *alpha * matrix->fx;
  if (const auto skew = file->number({"skew"}); skew && matrix) matrix->skew += *skew;
  constexpr std::array<std::size_t, 5> kCounts{4, 5, 8, 12, 14};
  const bool sound_count = std::ranges::find(kCounts, distortion.size()) != kCounts.end();
  const std::size_t given = distortion.size();
  while (model != NamedProjection::fisheye && distortion.size() > 5 && distortion.back() == 0.0) distortion.pop_back();
  const auto count = distortion.size();
  if (model == NamedProjection::fisheye && count != 4)
    problems.add("distortion_coefficients: {} numbers, expected the fisheye's 4: k1, k2, k3, k4", count);
  if ((model == NamedProjection::brown || model == NamedProjection::rational) && (!sound_count || count > 12))
    problems.add(
        "distortion_coefficients: {} numbers: expected 4, 5, 8 or 12 (k1, k2, p1, p2, k3, and those of the "
        "rational and thin prism models; a tilted sensor is not held)",
        given);
  if (model == NamedProjection::omnidirectional && (!xi || !(*xi >= 0.0) || count > 5))
    problems.add("xi, distortion_coefficients: expected omnidir's xi >= 0 and k1, k2, p1, p2");
  read_size(*file, kNone, lens, problems);
  check_whole_pictures(*file, lens, problems);
  for (const auto& broken : file->broken()) problems.add("{}: expected numbers alone", broken);
  lens.rms_px = file->number({"avg_reprojection_error", "rms", "reprojection_error", "RMS"});
  for (const auto& key : file->unread(kHarmless))
    problems.add(
        "{}: a number whose meaning is not known here: expected none but those of camera matrix, distortion, xi "
        "and size, for it may move pixels",
        key);
  if (!problems.empty()) return fail(problems.fault());
  if (model == NamedProjection::fisheye)
    set_fisheye(lens, *matrix, {distortion[0], distortion[1], distortion[2], distortion[3]});
  else if (model == NamedProjection::omnidirectional)
    set_omnidirectional(lens, *matrix, *xi, brown_of(distortion));
  else
    set_pinhole(lens, *matrix, brown_of(distortion));
  return lens;
}

}  // namespace kasumi
