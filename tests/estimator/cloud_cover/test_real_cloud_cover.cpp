// Cloud fraction and sky class of strangers' photographs with hand-made labels; see the shared data's README.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "estimator/cloud_cover/cloud_cover.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  }
  return cells;
}

std::vector<Row> labels(const std::filesystem::path& folder) {
  std::ifstream file(folder / "labels.csv");
  std::string line;
  std::getline(file, line);
  const auto names = cells_of(line);
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    const auto cells = cells_of(line);
    Row row;
    for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) row[names[i]] = cells[i];
    if (row["circle"] == "yes") rows.push_back(std::move(row));
  }
  return rows;
}

CloudCover cover_of(Row row, const std::filesystem::path& folder) {
  const cv::Mat image = cv::imread((folder / row["file"]).string(), cv::IMREAD_COLOR);
  if (image.empty()) throw std::runtime_error("cannot be read: " + row["file"]);
  Image<glm::vec3> encoded(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const auto& bgr = image.at<cv::Vec3b>(y, x);
      encoded.at(x, y) = glm::vec3(bgr[2], bgr[1], bgr[0]) / 255.0f;
    }
  const double half = from_degrees(90.0).value;
  Camera camera;
  camera.name = "sky";
  camera.width = image.cols;
  camera.height = image.rows;
  camera.lens = equidistant_lens({std::stod(row["cx"]), std::stod(row["cy"])}, std::stod(row["r"]) / half, {half});
  camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
  std::optional<SunDirection> sun;
  if (!row["sun_x"].empty()) sun = camera.direction_at({std::stod(row["sun_x"]), std::stod(row["sun_y"])});
  return cloud_cover(*sky_picture(encoded, 1.0 / 255.0, camera), camera, sun);
}

struct Tally {
  int pictures = 0;
  double sum = 0.0;
  void add(double value) { ++pictures, sum += value; }
  double mean() const { return sum / std::max(1, pictures); }
};

TEST(RealCloudCover, StrangersPicturesHaveTheirCloudFractionAndClass) {
  const auto folder = shared_data_folder() / "sky" / "real";
  if (!std::filesystem::exists(folder / "labels.csv")) GTEST_SKIP() << "no shared data: " << folder;
  Tally answered, error, covered;
  std::map<std::string, Tally> right;
  for (Row row : labels(folder)) {
    const CloudCover cover = cover_of(row, folder);
    if (row["sky"] == "unknown") {
      EXPECT_FALSE(cover.fraction) << row["id"];
    }
    if (row["sky"] != "unknown" && row["sky"] != "none") right[row["camera"]].add(name_of(cover.sky) == row["sky"]);
    if (row["cloud"].empty()) continue;
    answered.add(cover.fraction.has_value());
    if (!cover.fraction) continue;
    const double off = std::abs(*cover.fraction - std::stod(row["cloud"]));
    error.add(off);
    covered.add(off <= 2.0 * cover.sigma);
  }
  Tally classes;
  for (const auto& [camera, tally] : right) {
    std::printf("%-10s sky class right: %.0f %% of %d\n", camera.c_str(), 100.0 * tally.mean(), tally.pictures);
    classes.add(tally.mean());
  }
  std::printf(
      "fraction answered %.0f %% (goal 90), off by %.1f %% (10), within 2 sigma %.0f %% (95); classes right %.0f %% "
      "(85)\n",
      100.0 * answered.mean(), 100.0 * error.mean(), 100.0 * covered.mean(), 100.0 * classes.mean());
  EXPECT_GE(answered.mean(), 0.95);
  EXPECT_LE(error.mean(), 0.06);
  EXPECT_GE(covered.mean(), 0.90);
  EXPECT_GE(classes.mean(), 0.70);
  EXPECT_GE(right["wsiseg"].mean(), 0.75);
}

}  // namespace
}  // namespace kasumi
