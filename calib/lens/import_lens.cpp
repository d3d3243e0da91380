#include "calib/lens/import_lens.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <opencv2/core.hpp>

#include "base/files.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;

cv::FileNode first_of(const cv::FileStorage& file, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const auto node = file[name]; !node.empty()) return node;
  return {};
}

// A matrix, or a plain list of numbers.
std::vector<double> numbers_of(const cv::FileNode& node) {
  std::vector<double> numbers;
  if (node.isMap()) {
    cv::Mat matrix;
    node >> matrix;
    matrix.convertTo(matrix, CV_64F);
    if (matrix.channels() == 1) numbers.assign(matrix.begin<double>(), matrix.end<double>());
  } else if (node.isSeq()) {
    for (const auto& item : node)
      if (item.isInt() || item.isReal()) numbers.push_back(static_cast<double>(item));
  }
  const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
  return finite ? numbers : std::vector<double>{};
}

int whole_number(const cv::FileNode& node) {
  return node.isInt() ? static_cast<int>(node) : 0;
}

bool says_fisheye(const cv::FileStorage& file) {
  if (whole_number(file["fisheye_model"]) != 0) return true;
  const auto word = first_of(file, {"distortion_model", "camera_model", "model"});
  if (!word.isString()) return false;
  const auto text = static_cast<std::string>(word);
  return text == "fisheye" || text == "equidistant" || text == "KANNALA_BRANDT";
}

Result<ImportedLens> from_storage(const cv::FileStorage& file, const std::string& name) {
  Problems problems;
  const auto matrix = numbers_of(first_of(file, {"camera_matrix", "cameraMatrix", "CameraMatrix", "K"}));
  const bool good = matrix.size() == 9 && matrix[0] >= 1.0 && matrix[4] >= 1.0 && matrix[8] == 1.0;
  if (!good) problems.add("{}: camera_matrix: expected 9 numbers [fx 0 cx; 0 fy cy; 0 0 1] with fx, fy >= 1", name);
  auto distortion =
      numbers_of(first_of(file, {"distortion_coefficients", "distCoeffs", "DistCoeffs", "dist_coeffs", "D"}));
  const bool fisheye = says_fisheye(file);
  while (distortion.size() > 5 && distortion.back() == 0.0) distortion.pop_back();
  if (fisheye && distortion.size() != 4)
    problems.add("{}: distortion_coefficients: {} numbers, expected the fisheye's 4: k1, k2, k3, k4", name,
                 distortion.size());
  else if (!fisheye && distortion.size() > 5)
    problems.add(
        "{}: distortion_coefficients: {} numbers that are not 0, expected at most 5 (k1, k2, p1, p2, k3): calibrate "
        "without the rational, thin prism and tilted models",
        name, distortion.size());
  else if (!fisheye && distortion.size() < 4)
    problems.add("{}: distortion_coefficients: expected 4 or 5 numbers: k1, k2, p1, p2, k3", name);

  ImportedLens imported;
  imported.program = "OpenCV";
  imported.width = whole_number(first_of(file, {"image_width", "imageWidth", "width"}));
  imported.height = whole_number(first_of(file, {"image_height", "imageHeight", "height"}));
  if (const auto size = numbers_of(first_of(file, {"image_size", "imageSize"})); size.size() == 2 && !imported.width) {
    imported.width = static_cast<int>(std::clamp(size[0], 0.0, 1e5));
    imported.height = static_cast<int>(std::clamp(size[1], 0.0, 1e5));
  }
  if (imported.width <= 0 || imported.height <= 0)
    problems.add("{}: image_width, image_height: expected the size of the calibration's pictures", name);
  if (!problems.empty()) return fail(problems.fault());

  const glm::dvec2 focal{matrix[0], matrix[4]}, centre{matrix[2], matrix[5]};
  distortion.resize(5, 0.0);
  const auto& k = distortion;
  if (fisheye)
    imported.lens.model = OpencvFisheyeModel{focal, centre, {k[0], k[1], k[2], k[3]}};
  else
    imported.lens.model = PinholeModel{focal, centre, {k[0], k[1], k[2], k[3], k[4]}};
  const auto rms = first_of(file, {"avg_reprojection_error", "rms", "reprojection_error"});
  if (rms.isReal()) imported.rms_px = static_cast<double>(rms);
  return imported;
}

Result<ImportedLens> import_opencv(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());
  const auto name = path.string();
  if (text->size() > kLargestFile)
    return fail(FaultKind::bad_input, "{}: {} bytes, expected a calibration of at most {}", name, text->size(),
                kLargestFile);
  try {
    const cv::FileStorage file(*text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!file.isOpened()) return fail(FaultKind::bad_input, "{}: expected a calibration written by OpenCV", name);
    return from_storage(file, name);
  } catch (const cv::Exception& error) {
    return fail(FaultKind::bad_input, "{}: expected a calibration written by OpenCV ({})", name, error.err);
  }
}

}  // namespace

Result<ImportedLens> import_lens(const std::filesystem::path& path) {
  if (path.extension() != ".txt") return import_opencv(path);
  auto model = read_ocamcalib(path);
  if (!model) return fail(model.error());
  ImportedLens imported;
  imported.program = "OCamCalib";
  imported.width = model->width;
  imported.height = model->height;
  imported.lens.model = std::move(*model);
  return imported;
}

}  // namespace kasumi
