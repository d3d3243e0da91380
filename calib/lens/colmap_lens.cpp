// COLMAP's cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT PARAMS. Its pixel (0, 0) is the corner of the top left one.
#include <cmath>
#include <map>
#include <sstream>

#include "base/finite_number.hpp"
#include "calib/lens/choose_camera.hpp"
#include "calib/lens/foreign_formats.hpp"

namespace kasumi {
namespace {

struct ColmapLine {
  std::string id;
  std::string model;
  std::vector<double> numbers;  // width, height, parameters
};

std::vector<ColmapLine> colmap_lines(const std::string& text) {
  std::vector<ColmapLine> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string token;
    ColmapLine found;
    if (!(words >> found.id >> found.model) || !finite_number(found.id) || finite_number(found.model)) return {};
    while (words >> token) {
      const auto number = finite_number(token);
      if (!number) return {};
      found.numbers.push_back(*number);
    }
    if (found.numbers.size() < 3) return {};
    lines.push_back(std::move(found));
  }
  return lines;
}

// A fisheye that is distorted on the plane where r = theta, as COLMAP's THIN_PRISM_FISHEYE: k1 k2 p1 p2 k3 k4 sx1 sy1.
void set_thin_prism_fisheye(ForeignLens& lens, const SensorMatrix& matrix, const std::vector<double>& k) {
  lens.is_fisheye = true;
  lens.project = [matrix, k](const glm::dvec3& ray) -> std::optional<glm::dvec2> {
    const double off = std::hypot(ray.x, ray.y), theta = std::atan2(off, ray.z);
    if (off == 0.0) return matrix({0.0, 0.0});
    const double u = theta * ray.x / off, v = theta * ray.y / off, u2 = u * u, uv = u * v, v2 = v * v, r2 = u2 + v2;
    const double radial = r2 * (k[0] + r2 * (k[1] + r2 * (k[4] + r2 * k[5])));
    return matrix({u + u * radial + 2.0 * k[2] * uv + k[3] * (r2 + 2.0 * u2) + k[6] * r2,
                   v + v * radial + 2.0 * k[3] * uv + k[2] * (r2 + 2.0 * v2) + k[7] * r2});
  };
}

}  // namespace

bool is_colmap(const std::string& text) {
  const auto lines = colmap_lines(text);
  return !lines.empty();
}

Result<ForeignLens> read_colmap_lens(const std::string& text, const ImportQuestions& questions) {
  static const std::map<std::string, std::size_t> kParameters{{"SIMPLE_PINHOLE", 3},
                                                              {"PINHOLE", 4},
                                                              {"SIMPLE_RADIAL", 4},
                                                              {"RADIAL", 5},
                                                              {"OPENCV", 8},
                                                              {"OPENCV_FISHEYE", 8},
                                                              {"FULL_OPENCV", 12},
                                                              {"FOV", 5},
                                                              {"SIMPLE_RADIAL_FISHEYE", 4},
                                                              {"RADIAL_FISHEYE", 5},
                                                              {"THIN_PRISM_FISHEYE", 12}};
  const auto lines = colmap_lines(text);
  std::vector<ListedLens> cameras;
  for (const auto& line : lines)
    cameras.push_back({{line.id}, fmt::format("{}, {:g} x {:g}", line.model, line.numbers[0], line.numbers[1])});
  const auto chosen = choose_camera(cameras, questions.camera);
  if (!chosen) return fail(chosen.error());
  const auto& [id, model, n] = lines[*chosen];
  const auto known = kParameters.find(model);
  if (known == kParameters.end())
    return fail(FaultKind::bad_input, "model {}: expected one of COLMAP's, SIMPLE_PINHOLE to THIN_PRISM_FISHEYE",
                model);
  if (n.size() != known->second + 2)
    return fail(FaultKind::bad_input, "model {}: {} parameters, expected {}", model, n.size() - 2, known->second);
  ForeignLens lens{"COLMAP", model, static_cast<int>(n[0]), static_cast<int>(n[1]), {}, {}, false, {}};
  if (!(n[0] >= 1.0 && n[1] >= 1.0 && n[0] <= 1e5 && n[1] <= 1e5 && n[2] >= 1.0))
    return fail(FaultKind::bad_input, "width, height, focal length {} {} {}: expected numbers >= 1", n[0], n[1], n[2]);
  const bool one_focal = model.starts_with("SIMPLE") || model.starts_with("RADIAL");
  const double* k = n.data() + (one_focal ? 5 : 6);
  const SensorMatrix matrix{n[2], one_focal ? n[2] : n[3], n[one_focal ? 3 : 4] - 0.5, n[one_focal ? 4 : 5] - 0.5, 0.0};
  if (!(matrix.fy >= 1.0)) return fail(FaultKind::bad_input, "focal length {}: expected a number >= 1", matrix.fy);
  if (model == "SIMPLE_RADIAL")
    set_pinhole(lens, matrix, {k[0]});
  else if (model == "RADIAL")
    set_pinhole(lens, matrix, {k[0], k[1]});
  else if (model == "OPENCV")
    set_pinhole(lens, matrix, {k[0], k[1], k[2], k[3]});
  else if (model == "FULL_OPENCV")
    set_pinhole(lens, matrix, {k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7]});
  else if (model == "OPENCV_FISHEYE")
    set_fisheye(lens, matrix, {k[0], k[1], k[2], k[3]});
  else if (model == "SIMPLE_RADIAL_FISHEYE")
    set_fisheye(lens, matrix, {k[0], 0.0, 0.0, 0.0});
  else if (model == "RADIAL_FISHEYE")
    set_fisheye(lens, matrix, {k[0], k[1], 0.0, 0.0});
  else if (model == "THIN_PRISM_FISHEYE")
    set_thin_prism_fisheye(lens, matrix, {k, k + 8});
  else if (model == "FOV")
    set_field_of_view(lens, matrix, k[0]);
  else
    set_pinhole(lens, matrix, {});
  return lens;
}

}  // namespace kasumi
