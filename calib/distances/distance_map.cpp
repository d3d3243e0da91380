#include "calib/distances/distance_map.hpp"

#include <cmath>

#include <opencv2/core.hpp>

#include "base/files.hpp"
#include "base/picture_files/decode_picture.hpp"
#include "base/picture_header.hpp"

namespace kasumi {
namespace {

// Empty: damaged, or no picture.
Result<cv::Mat> decoded(const std::optional<PictureHeader>& header, const std::vector<std::uint8_t>& bytes) {
  if (!header) return cv::Mat();
  auto map = decode_picture_file(*header, bytes);
  if (!map && map.error().kind == FaultKind::bad_input) return cv::Mat();
  return map;
}

// Replaces infinity by 0. Returns what was expected in place of the first bad value.
std::optional<std::string> clean_distances(Image<float>& distances_m) {
  for (int y = 0; y < distances_m.height(); ++y)
    for (int x = 0; x < distances_m.width(); ++x) {
      float& value = distances_m.at(x, y);
      if (std::isnan(value) || value < 0.0f) return fmt::format("metres >= 0 (pixel {}, {} is {})", x, y, value);
      if (std::isinf(value)) value = 0.0f;
    }
  return std::nullopt;
}

bool in_steps(const cv::Mat& map) {
  return map.type() == CV_16UC1;
}
Image<float> metres_of(const cv::Mat& map, double step_m) {
  Image<float> distances_m(map.cols, map.rows);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x)
      distances_m.at(x, y) =
          in_steps(map) ? static_cast<float>(step_m * map.at<std::uint16_t>(y, x)) : map.at<float>(y, x);
  return distances_m;
}

}  // namespace

Image<float> read_distance_map(const ConfigTable& scene, int width, int height) {
  const auto path = scene.optional_file("depth_map");
  const double step_m = scene.number("depth_step_m", {1e-3, 1e3}, 0.0);
  if (!path && scene.has("depth_step_m"))
    scene.problem("depth_step_m", "it together with depth_map, whose steps it measures");
  std::error_code error;
  if (!path || !std::filesystem::is_regular_file(*path, error)) return {};

  const auto bytes = read_file(*path);
  if (!bytes) {
    scene.problem("depth_map", fmt::format("a file that can be read ({})", bytes.error().message));
    return {};
  }
  const auto header = picture_header(*bytes);
  if (header && !header->is(width, height)) {
    scene.problem("depth_map", fmt::format("a map as large as the camera's pictures, {} x {} (it is {} x {})", width,
                                           height, header->width, header->height));
    return {};
  }
  const auto read = decoded(header, *bytes);
  if (!read) {
    scene.problem("depth_map", fmt::format("a file that can be read ({})", read.error().message));
    return {};
  }
  const cv::Mat& map = *read;
  const bool in_metres = map.type() == CV_32FC1;
  if (map.empty() || !(in_steps(map) || in_metres) || map.cols != width || map.rows != height) {
    scene.problem("depth_map", "a grey PNG of 16 bits, or a grey PFM of metres");
    return {};
  }
  if (in_steps(map) && !scene.has("depth_step_m"))
    scene.problem("depth_step_m", "the metres that a step of the PNG is");
  if (in_metres && scene.has("depth_step_m")) scene.problem("depth_step_m", "no such key: a PFM is in metres");
  auto distances_m = metres_of(map, step_m);
  if (const auto wrong = clean_distances(distances_m)) {
    scene.problem("depth_map", *wrong);
    return {};
  }
  return distances_m;
}

Result<Image<float>> read_distances(const std::filesystem::path& path, std::optional<double> step_m) {
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  const auto header = picture_header(*bytes);
  if (header)
    if (auto bounded = check_size(*header, kPhotographLimits); !bounded)
      return fail(FaultKind::bad_input, "{}: {}", path.string(), bounded.error().message);
  const auto read = decoded(header, *bytes);
  if (!read) return fail(read.error().kind, "{}: {}", path.string(), read.error().message);
  const cv::Mat& map = *read;
  if (map.empty() || !(in_steps(map) || map.type() == CV_32FC1))
    return fail(FaultKind::bad_input, "{}: expected a depth map: a grey PNG of 16 bits, or a grey PFM or EXR of metres",
                path.string());
  if (in_steps(map) && !step_m)
    return fail(FaultKind::bad_input, "{}: expected the metres that a step of this PNG is, too (--depth-step-m)",
                path.string());
  if (!in_steps(map) && step_m)
    return fail(FaultKind::bad_input, "{}: is in metres: expected no metres of a step (--depth-step-m)", path.string());
  auto distances_m = metres_of(map, step_m.value_or(1.0));
  if (const auto wrong = clean_distances(distances_m))
    return fail(FaultKind::bad_input, "{}: expected {}", path.string(), *wrong);
  return distances_m;
}

}  // namespace kasumi
